# SPDX-FileCopyrightText: diffcal_ros maintainers
# SPDX-License-Identifier: Apache-2.0
"""The report's style sheet: no fonts, pictures or scripts from elsewhere."""

from html import escape

_STYLE = """
:root { color-scheme: light; --ink: #111827; --soft: #4b5563; --line: #e5e7eb;
        --page: #f8fafc; --card: #ffffff; --good: #166534; --care: #92400e; --bad: #991b1b; }
* { box-sizing: border-box; }
body { margin: 0; background: var(--page); color: var(--ink); line-height: 1.5;
       font: 16px/1.5 system-ui, "Segoe UI", Roboto, "Helvetica Neue", Arial, sans-serif; }
main { max-width: 1200px; margin: 0 auto; padding: 1.5rem 1.2rem 4rem; }
h1 { font-size: 1.5rem; margin: 0 0 .2rem; }
h2 { font-size: 1.2rem; margin: 2.4rem 0 .6rem; }
h3 { font-size: 1rem; margin: 1.4rem 0 .4rem; }
p { margin: .4rem 0; max-width: 75ch; }
.soft { color: var(--soft); }
.cards { display: grid; gap: .9rem; margin: 1.2rem 0;
         grid-template-columns: repeat(auto-fit, minmax(235px, 1fr)); }
.card { background: var(--card); border: 1px solid var(--line); border-radius: 10px;
        padding: .9rem 1.1rem; }
.card .label { color: var(--soft); font-size: .88rem; }
.card .value { font-size: 1.7rem; font-weight: 650; line-height: 1.25;
               font-variant-numeric: tabular-nums; }
.card .value small { font-size: 1rem; font-weight: 500; color: var(--soft); }
.card .more { font-size: .88rem; color: var(--soft); }
.outcome { border-left: 6px solid var(--soft); }
.outcome.good { border-left-color: var(--good); }
.outcome.care { border-left-color: #d97706; }
.outcome.bad { border-left-color: var(--bad); }
.outcome .value { font-size: 1.3rem; }
/* As on a terminal, but long lines are continued beneath themselves. */
.said { font: .88rem/1.5 ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace;
        white-space: pre-wrap; overflow-wrap: anywhere; padding-left: 10ch; text-indent: -10ch; }
.good .value { color: var(--good); } .care .value { color: var(--care); }
.bad .value { color: var(--bad); }
ul.warnings { background: #fffbeb; border: 1px solid #fcd34d; border-radius: 10px;
              padding: .7rem 1rem .7rem 2.1rem; margin: .8rem 0; }
figure { margin: .6rem 0 1rem; background: var(--card); border: 1px solid var(--line);
         border-radius: 10px; padding: .7rem; }
figure img { display: block; width: 100%; height: auto; }
figcaption { color: var(--soft); font-size: .88rem; padding: .4rem .3rem 0; max-width: 100ch; }
.wide { overflow-x: auto; }
table { border-collapse: collapse; background: var(--card); font-size: .92rem;
        font-variant-numeric: tabular-nums; margin: .4rem 0; }
th, td { border: 1px solid var(--line); padding: .3rem .6rem; text-align: left;
         vertical-align: top; }
th { background: #f1f5f9; font-weight: 600; }
td.number, th.number { text-align: right; white-space: nowrap; }
table.heat td { text-align: center; min-width: 3.4rem; }
tr.group th { background: #e2e8f0; }
code { font: .88em ui-monospace, "DejaVu Sans Mono", Menlo, Consolas, monospace;
       overflow-wrap: anywhere; }
details { margin: .6rem 0; } summary { cursor: pointer; color: var(--soft); }
@media print { body { background: #fff; } figure, .card { break-inside: avoid; }
               details > * { display: revert; } }
"""


def document(title: str, body: str) -> str:
    """Return a page that needs nothing else.

    Args:
        title: of the page, plain text.
        body: what stands in it, HTML.
    """
    return (
        '<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
        '<meta name="viewport" content="width=device-width, initial-scale=1">\n'
        f'<title>{escape(title, quote=False)}</title>\n<style>{_STYLE}</style>\n</head>\n'
        f'<body>\n<main>\n{body}</main>\n</body>\n</html>\n'
    )
