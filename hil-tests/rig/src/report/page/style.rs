//! How the page looks: light, dark and printed. Everything has its colour by class, so that one file serves all.

/// Width of drawings in pixels.
pub(super) const WIDTH_PX: f64 = 1180.0;
/// Robots have this many colours; more robots share them.
pub(super) const COLOURS: usize = 8;

/// The whole style sheet. Robots' colours can be told apart by people with any colour vision (after Okabe and Ito);
/// red is kept for what is wrong.
pub(super) const STYLE: &str = "\
:root{color-scheme:light dark;--bg:#fff;--ink:#0f172a;--text:#334155;--soft:#64748b;--line:#cbd5e1;--faint:#e8edf3;\
--floor:#f4f6f9;--wall:#1e293b;--on:#fff;--bad:#dc2626;--good:#15803d;--coord:#475569;\
--r0:#0072b2;--r1:#c96a00;--r2:#00855f;--r3:#a23e8c;--r4:#3f97cf;--r5:#7d6b00;--r6:#6849c6;--r7:#8c564b}
@media screen and (prefers-color-scheme:dark){:root{--bg:#0f1521;--ink:#f1f5f9;--text:#cbd5e1;--soft:#94a3b8;\
--line:#475569;--faint:#232d3d;--floor:#182131;--wall:#e2e8f0;--on:#0b1220;--bad:#f87171;--good:#4ade80;--coord:#94a3b8;\
--r0:#58b1ee;--r1:#f5a742;--r2:#2fcf9f;--r3:#e493cf;--r4:#9ad6ff;--r5:#d8c648;--r6:#b49df5;--r7:#d6a795}}
*{box-sizing:border-box}
body{margin:0 auto;padding:28px 24px 48px;max-width:1228px;background:var(--bg);color:var(--text);\
font:14px/1.45 'Helvetica Neue',Arial,'DejaVu Sans',sans-serif;-webkit-print-color-adjust:exact;print-color-adjust:exact}
h1{font-size:27px;line-height:1.2;margin:0;color:var(--ink)}h2{font-size:19px;color:var(--ink);margin:38px 0 6px}
h3{font-size:15px;color:var(--ink);margin:22px 0 4px}p{margin:.3em 0 .7em;max-width:92ch}.soft{color:var(--soft)}
.top{display:flex;flex-wrap:wrap;gap:8px 18px;align-items:center;justify-content:space-between}
.badge{border-radius:18px;padding:6px 16px;font-weight:700;color:var(--bg);font-size:16px;background:var(--bad)}
.badge.well{background:var(--good)}
.facts{display:flex;flex-wrap:wrap;gap:12px 34px;margin:16px 0 4px;padding:12px 0;border:solid var(--line);border-width:1px 0}
.facts dt{font-size:12.5px;color:var(--soft)}.facts dd{margin:0;font-size:20px;font-weight:600;color:var(--ink)}
.facts dd.bad,.bad{color:var(--bad)}.facts dd.long{font-size:15px;line-height:29px}
ul.wrong{margin:.4em 0 1em;padding-left:1.2em}ul.wrong b{color:var(--bad)}
.scroll{overflow-x:auto;margin:8px 0 14px}table{border-collapse:collapse;font-size:13px;font-variant-numeric:tabular-nums}
th,td{padding:3px 10px;text-align:right;border-bottom:1px solid var(--faint);white-space:nowrap;vertical-align:top}
th{white-space:normal;max-width:8em;font-weight:600;color:var(--soft);border-bottom-color:var(--line);vertical-align:bottom}
th.l,td.l{text-align:left}td.w{white-space:normal;min-width:16em}th:first-child,td:first-child{padding-left:2px}
.sw{display:inline-block;width:11px;height:11px;border-radius:3px;background:var(--c);margin-right:7px;vertical-align:-1px}
figure{margin:10px 0 20px;break-inside:avoid}figcaption{font-size:13px;color:var(--soft);max-width:110ch;margin-top:2px}
.keys{display:flex;flex-wrap:wrap;gap:3px 20px;margin:4px 0 6px;font-size:13px}\
.keys span{display:inline-flex;align-items:center;gap:6px}
svg{max-width:100%;height:auto;display:block}.frames{display:grid;grid-template-columns:repeat(3,1fr);gap:10px 14px}\
.frames svg{width:100%}.frames div{font-size:13px}.frames .wall{stroke-width:2.5}
.net{display:flex;flex-wrap:wrap;gap:10px 28px;align-items:flex-start}
details{margin:6px 0 14px}summary{cursor:pointer;color:var(--soft)}
text{font:13px 'Helvetica Neue',Arial,'DejaVu Sans',sans-serif;fill:var(--text)}.m{text-anchor:middle}.e{text-anchor:end}
.b{font-weight:700}text.bad{fill:var(--bad)}.tick,.note{font-size:12px;fill:var(--soft)}.axis{font-size:13px;fill:var(--soft)}\
.small{font-size:11px}.cap{font-size:14px;font-weight:600;fill:var(--ink)}
.halo{paint-order:stroke;stroke:var(--bg);stroke-width:3.5px;stroke-linejoin:round}
.frame{fill:none;stroke:var(--line)}.grid{stroke:var(--faint)}.mark{stroke:var(--soft)}.rule{stroke:var(--line)}
.area{fill:var(--floor);stroke:var(--line);stroke-width:1}.id{font-size:17px;font-weight:700;fill:var(--soft)}
.free{fill:var(--bg);stroke:var(--line);stroke-width:.8}.wall{stroke:var(--wall);stroke-width:4;stroke-linecap:round}.lane{stroke:var(--line);stroke-width:1.2;stroke-dasharray:9 5}
.arrow{fill:none;stroke:var(--line);stroke-width:1.6}.scale{stroke:var(--wall);stroke-width:2.5;stroke-linecap:round}
.path{fill:none;stroke:var(--c);stroke-linejoin:round;stroke-linecap:round}
.ghost{fill:var(--c);fill-opacity:.09;stroke:var(--c);stroke-opacity:.55}
.here{fill:var(--c);fill-opacity:.5;stroke:var(--c);stroke-width:1.6}
.start{fill:var(--bg);fill-opacity:.5;stroke:var(--c);stroke-width:1.8;stroke-dasharray:4 2}
.pip{stroke:var(--c);stroke-width:2}.name{fill:var(--c);font-weight:700}.lead{stroke:var(--c);stroke-width:1}
.hit{fill:none;stroke:var(--bad);stroke-width:2.5}.when{stroke:var(--bad);stroke-width:1.3}
.own{fill:var(--c)}.hold{fill:var(--c);fill-opacity:.28}.edge{fill:none;stroke:var(--c);stroke-width:1}
.onbar{fill:var(--on);font-size:11px;font-weight:700}.inbar{fill:var(--c);font-size:11px;font-weight:700}
.band{fill:var(--coord);fill-opacity:.1}.bandedge{stroke:var(--coord);stroke-dasharray:3 3}\
.bandbar{fill:var(--coord)}.fire{fill:none;stroke:var(--coord);stroke-width:1.2}
.row{fill:var(--floor)}.off{fill:var(--bad);fill-opacity:.1}
.speed{fill:none;stroke:var(--c);stroke-width:1.4;stroke-linejoin:round}.under{fill:var(--c);fill-opacity:.12}
.state{fill:var(--floor);stroke:var(--line);stroke-width:.6}
.limit{stroke:var(--bad);stroke-dasharray:6 4}.bar{fill:var(--c)}.q1{fill:var(--c);fill-opacity:.85}\
.q2{fill:var(--c);fill-opacity:.4}.q3{stroke:var(--c);stroke-width:1.5}.q4{fill:var(--bg);stroke:var(--c);stroke-width:1.5}
.neutral{--c:var(--coord)}
.place{fill:var(--bg);stroke:var(--ink);stroke-width:1.5}.token{fill:var(--ink)}
.source{fill:var(--c);stroke:var(--c);stroke-width:1.5}.sink{fill:var(--bg);stroke:var(--c);stroke-width:1.5}\
.ring{fill:none;stroke:var(--c);stroke-width:1}
.trans{fill:var(--ink)}.arc{fill:none;stroke:var(--ink);stroke-width:1.2}.tip{fill:var(--ink)}
.io{fill:none;stroke:var(--c);stroke-width:1.2}.iotip{fill:var(--c)}.never .trans,.never .tip{fill:var(--line)}\
.never .arc{stroke:var(--line)}.never text{fill:var(--soft)}
.nr{fill:var(--coord)}.nrtext{font-size:11px;font-weight:700;fill:var(--bg);text-anchor:middle}.about{fill:var(--soft);font-size:11px}
@media print{body{padding:0;font-size:11px}h2{break-after:avoid}table{font-size:10px}.scroll{overflow:visible}\
th,td{padding:2px 5px}details::details-content{content-visibility:visible;display:block}tr{break-inside:avoid}}
@page{margin:14mm}
";

/// Rules and patterns for each of the robots' colours.
pub(super) fn colours() -> (String, String) {
    let (mut rules, mut patterns) = (String::new(), String::new());
    for index in 0..COLOURS {
        rules.push_str(&format!(
            ".r{index}{{--c:var(--r{index})}}.r{index} .ask{{fill:url(#ask{index})}}\n"
        ));
        patterns.push_str(&format!(
            "<pattern id=\"ask{index}\" class=\"r{index}\" width=\"5\" height=\"5\" patternUnits=\"userSpaceOnUse\" \
             patternTransform=\"rotate(45)\"><rect class=\"own\" width=\"1.7\" height=\"5\"/></pattern>\n"
        ));
    }
    (rules, patterns)
}
