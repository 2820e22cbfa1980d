#include "app/report_style.h"

#include "app/report_html.h"

namespace irradia::app {
namespace {

// Neither style nor script may hold '<' or '&': the page is XML as well.
const char* const kStyle = R"css(
:root { color-scheme: light dark; --page: #f6f6f4; --card: #ffffff; --ink: #1c1c1a; --soft: #5d5d58; --line: #dcdcd6;
  --bar: #2f6db5; --track: #ecece7; --warn: #fff1d6; --warn-ink: #6b4300; --mark: #e8f0fa; }
@media (prefers-color-scheme: dark) { :root { --page: #161615; --card: #20201f; --ink: #ececE8; --soft: #a5a59f;
  --line: #383835; --bar: #6ba5e8; --track: #2f2f2d; --warn: #3d2f12; --warn-ink: #ffd894; --mark: #233246; } }
* { box-sizing: border-box; }
body { margin: 0 auto; max-width: 76rem; padding: 1rem clamp(.75rem, 3vw, 2rem) 3rem; background: var(--page);
  color: var(--ink); font: 16px/1.5 system-ui, "Segoe UI", Roboto, "DejaVu Sans", sans-serif; }
h1 { font-size: 1.7rem; line-height: 1.2; margin: .5rem 0 .1rem; overflow-wrap: anywhere; }
h2 { font-size: 1.2rem; margin: 0 0 .6rem; }
h3 { font-size: .95rem; margin: .3rem 0 .4rem; font-weight: 600; }
p { margin: .2rem 0 .8rem; overflow-wrap: anywhere; }
header p, .note, figcaption, section > p { color: var(--soft); }
.note { font-size: .85rem; margin: .5rem 0 0; }
section { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: 1rem; margin: 1rem 0; }
.figures { display: grid; grid-template-columns: repeat(auto-fit, minmax(9.5rem, 1fr)); gap: .6rem; margin: .8rem 0 0; }
.figure { background: var(--card); border: 1px solid var(--line); border-radius: 10px; padding: .5rem .8rem; }
.figure dt { color: var(--soft); font-size: .8rem; }
.figure dd { margin: 0; font-size: 1.3rem; font-weight: 600; font-variant-numeric: tabular-nums; }
.figure small { display: block; font-size: .78rem; font-weight: 400; color: var(--soft); }
.viewer { position: relative; overflow: hidden; margin: 0 auto; border-radius: 6px; background: #000; }
.viewer img { display: block; width: 100%; height: 100%; transform-origin: 0 0; user-select: none; }
.viewer:focus-visible, button:focus-visible { outline: 3px solid var(--bar); outline-offset: 2px; }
.viewer.zoomed { cursor: grab; touch-action: none; }
img.small, .near img { image-rendering: pixelated; }
.tools { display: flex; flex-wrap: wrap; gap: .35rem; align-items: center; margin: 0 0 .6rem; }
.tools span { display: flex; gap: .35rem; align-items: center; margin-left: auto; }
.tools output { font-size: .85rem; color: var(--soft); font-variant-numeric: tabular-nums; min-width: 8.5rem;
  text-align: right; }
button { font: inherit; font-size: .85rem; color: var(--ink); background: var(--card); border: 1px solid var(--line);
  border-radius: 6px; padding: .25rem .6rem; cursor: pointer; min-height: 2rem; min-width: 2rem; }
button:hover { border-color: var(--bar); }
button[aria-pressed="true"] { background: var(--bar); border-color: var(--bar); color: var(--card); }
.grid { display: grid; grid-template-columns: repeat(auto-fill, minmax(min(100%, 13.5rem), 1fr)); gap: 1rem; }
.grid.wide { grid-template-columns: repeat(auto-fit, minmax(min(100%, 24rem), 1fr)); }
figure { margin: 0; min-width: 0; }
figure img { display: block; width: 100%; height: auto; border-radius: 6px; border: 1px solid var(--line); }
figure.linked img { cursor: zoom-in; }
figcaption { font-size: .85rem; padding: .4rem 0 0; }
figcaption strong, .scale-name { color: var(--ink); }
#records figure img { max-width: calc(80vh * 1.5); margin: 0 auto; }
#records figure + figure { margin-top: 1.2rem; }
.columns { display: grid; grid-template-columns: repeat(auto-fit, minmax(min(100%, 22rem), 1fr)); gap: 1rem 2rem;
  align-items: start; }
.grid + .columns { margin-top: 1rem; }
.columns > div { min-width: 0; }
svg { display: block; overflow: visible; }
svg text { font-size: 13px; fill: var(--ink); }
svg .value { text-anchor: end; }
svg .middle { text-anchor: middle; }
.bars .value, .intervals .value { fill: var(--soft); font-variant-numeric: tabular-nums; }
.track { fill: var(--track); } .bar { fill: var(--bar); }
.legend { margin: .35rem 0 0; } .legend text { font-size: 12px; fill: var(--soft); }
.tick, .zero { stroke: var(--soft); stroke-width: 1; }
.whisker { stroke: var(--bar); stroke-width: 3; stroke-linecap: round; opacity: .5; } .dot { fill: var(--bar); }
.intervals { margin: 0 0 .8rem; max-width: 40rem; }
table { border-collapse: collapse; width: 100%; font-size: .85rem; margin: 0 0 1rem; table-layout: fixed; }
caption { text-align: left; font-weight: 600; font-size: .95rem; padding: 0 0 .3rem; }
th, td { text-align: left; font-weight: 400; padding: .2rem .4rem; border-top: 1px solid var(--line);
  vertical-align: top; overflow-wrap: anywhere; }
th { color: var(--soft); width: 45%; } td { font-variant-numeric: tabular-nums; }
.marked th, .marked td { background: var(--mark); color: var(--ink); } .marked td { font-weight: 600; }
.warning { background: var(--warn); color: var(--warn-ink) !important; border-radius: 6px; padding: .5rem .7rem; }
@media print { .tools { display: none; } section { break-inside: avoid; } }
)css";

// Zoom, and the other pictures of the page in the viewer. Without it the page shows all the same pictures, smaller.
const char* const kScript = R"js(
'use strict';
(function () {
  var viewer = document.getElementById('viewer'), image = document.getElementById('viewed');
  var width = image.width, height = image.height, native = { w: +image.getAttribute('width'), h: +image.getAttribute('height') };
  var zoom = 1, left = 0, top = 0, pointers = new Map(), last = null;
  var tools = document.createElement('div');
  tools.className = 'tools';
  tools.setAttribute('role', 'toolbar');
  tools.setAttribute('aria-label', 'What the viewer shows');
  viewer.before(tools);
  var place = document.createElement('output'), zooming = document.createElement('span');
  function clamp(x, low, high) { return Math.min(Math.max(x, low), high); }
  function fit() { return viewer.clientWidth / native.w; }
  function show() {
    left = clamp(left, viewer.clientWidth * (1 - zoom), 0);
    top = clamp(top, viewer.clientHeight * (1 - zoom), 0);
    image.style.transform = 'translate(' + left + 'px,' + top + 'px) scale(' + zoom + ')';
    viewer.classList.toggle('zoomed', zoom > 1);
    viewer.classList.toggle('near', zoom * fit() > 2);
    place.textContent = Math.round(100 * zoom * fit()) + ' %';
  }
  function zoomTo(next, x, y) {
    next = clamp(next, 1, Math.max(8, 32 / fit()));
    left = x - (x - left) * next / zoom;
    top = y - (y - top) * next / zoom;
    zoom = next;
    show();
  }
  function zoomBy(factor) { zoomTo(zoom * factor, viewer.clientWidth / 2, viewer.clientHeight / 2); }
  function at(event) {
    var box = viewer.getBoundingClientRect();
    return { x: event.clientX - box.left, y: event.clientY - box.top };
  }
  function button(parent, text, label, act) {
    var b = document.createElement('button');
    b.type = 'button';
    b.textContent = text;
    if (label) b.setAttribute('aria-label', label);
    b.addEventListener('click', function () { act(b); });
    parent.append(b);
    return b;
  }
  var choices = [];
  function choose(b, from) {
    choices.forEach(function (c) { c.setAttribute('aria-pressed', String(c === b)); });
    image.src = from.src;
    image.alt = from.alt;
  }
  var own = { src: image.src, alt: image.alt };
  choices.push(button(tools, 'Picture', '', function (b) { choose(b, own); }));
  choices[0].setAttribute('aria-pressed', 'true');
  document.querySelectorAll('img.shown').forEach(function (shown) {
    var b = button(tools, shown.dataset.title, '', function (self) { choose(self, shown); });
    b.setAttribute('aria-pressed', 'false');
    choices.push(b);
    shown.parentNode.classList.add('linked');
    shown.addEventListener('click', function () {
      choose(b, shown);
      document.getElementById('picture').scrollIntoView();
    });
  });
  zooming.append(place);
  tools.append(zooming);
  button(zooming, '\u2212', 'Zoom out', function () { zoomBy(1 / 1.5); });
  button(zooming, '+', 'Zoom in', function () { zoomBy(1.5); });
  button(zooming, '1:1', 'One pixel of the picture on one of the page', function () {
    zoomTo(1 / fit(), viewer.clientWidth / 2, viewer.clientHeight / 2);
  });
  button(zooming, 'Whole', 'The whole picture', function () { zoom = 1; show(); });
  viewer.tabIndex = 0;
  viewer.setAttribute('role', 'group');
  viewer.setAttribute('aria-label', 'Picture; plus and minus zoom, arrows move, 0 shows the whole');
  viewer.addEventListener('wheel', function (event) {
    event.preventDefault();
    var p = at(event);
    zoomTo(zoom * Math.exp(-clamp(event.deltaY, -200, 200) * 0.003), p.x, p.y);
  }, { passive: false });
  viewer.addEventListener('keydown', function (event) {
    var step = { ArrowLeft: [60, 0], ArrowRight: [-60, 0], ArrowUp: [0, 60], ArrowDown: [0, -60] }[event.key];
    if (step) { left += step[0]; top += step[1]; show(); }
    else if (event.key === '+' || event.key === '=') zoomBy(1.5);
    else if (event.key === '-') zoomBy(1 / 1.5);
    else if (event.key === '0') { zoom = 1; show(); }
    else return;
    event.preventDefault();
  });
  viewer.addEventListener('dragstart', function (event) { event.preventDefault(); });
  viewer.addEventListener('pointerdown', function (event) {
    pointers.set(event.pointerId, at(event));
    viewer.setPointerCapture(event.pointerId);
    last = null;
  });
  viewer.addEventListener('pointermove', function (event) {
    var p = at(event), now;
    place.textContent = 'x ' + clamp(Math.floor((p.x - left) / zoom / fit()), 0, native.w - 1) + ', y ' +
      clamp(Math.floor((p.y - top) / zoom / fit()), 0, native.h - 1) + ', ' + Math.round(100 * zoom * fit()) + ' %';
    if (!pointers.has(event.pointerId)) return;
    pointers.set(event.pointerId, p);
    var all = Array.from(pointers.values());
    if (all.length > 1) {
      now = { x: (all[0].x + all[1].x) / 2, y: (all[0].y + all[1].y) / 2,
              d: Math.hypot(all[0].x - all[1].x, all[0].y - all[1].y) };
    } else now = { x: p.x, y: p.y, d: 0 };
    if (last) {
      left += now.x - last.x;
      top += now.y - last.y;
      if (now.d > 0) { if (last.d > 0) zoomTo(zoom * now.d / last.d, now.x, now.y); }
      show();
    }
    last = now;
  });
  ['pointerup', 'pointercancel'].forEach(function (name) {
    viewer.addEventListener(name, function (event) { pointers.delete(event.pointerId); last = null; });
  });
  document.querySelector('#picture .note').append(' Wheel, pinch and drag zoom and move it; the other pictures are shown here too.');
  window.addEventListener('resize', show);
  show();
})();
)js";

}  // namespace

std::string page_begin(const std::string& title) {
    // The policy: nothing is fetched from anywhere, whatever the page may hold.
    return "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\" />\n"
           "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\" />\n"
           "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; "
           "style-src 'unsafe-inline'; script-src 'unsafe-inline'\" />\n"
           "<meta name=\"generator\" content=\"Irradia " IRRADIA_VERSION "\" />\n<title>" +
           html::escape(title) + "</title>\n<style>" + kStyle + "</style>\n</head>\n<body>\n";
}

std::string page_end() { return std::string("<script>") + kScript + "</script>\n</body>\n</html>\n"; }

}  // namespace irradia::app
