#pragma once

#include <string>

namespace rigcal {

/// What is put around report.html in a browser: notes every complaint of the browser from the start, and, when the page
/// is there, what it looks like, as JSON in #harness of the page that frames it (`frame_of`). Of the page itself it
/// needs the view's canvas only.
inline std::string with_harness(std::string page) {
  const std::string begin = R"(<head><script>
var problems = [];
addEventListener('error', function (e) { problems.push(String(e.message || e.target)); }, true);
addEventListener('unhandledrejection', function (e) { problems.push(String(e.reason)); });
addEventListener('securitypolicyviolation', function (e) { problems.push('policy: ' + e.violatedDirective); });
// All within the load event: a browser without a screen waits for nothing that comes later.
window.requestAnimationFrame = function (draw) { draw(performance.now()); return 0; };
console.error = function () { problems.push(Array.prototype.join.call(arguments, ' ')); };
</script>)";
  const std::string end = R"(<script>
addEventListener('load', function () {
  var report = { load_ms: performance.now(), problems: problems };
  function tell() { parent.postMessage(JSON.stringify(report), '*'); }
  tell();
  function pixelsOf(source, width, height) {
    var canvas = document.createElement('canvas');
    canvas.width = width;
    canvas.height = height;
    var pen = canvas.getContext('2d');
    pen.drawImage(source, 0, 0, width, height);
    return pen.getImageData(0, 0, width, height).data;
  }
  function differing(a, b) {
    var count = 0;
    for (var i = 0; i < a.length; i += 4) {
      if (Math.abs(a[i] - b[i]) + Math.abs(a[i + 1] - b[i + 1]) + Math.abs(a[i + 2] - b[i + 2]) > 30) ++count;
    }
    return count / (a.length / 4);
  }
  report.screen = [innerWidth, innerHeight];
  report.first_screen = Array.from(document.querySelectorAll('h1, h3, li, header p')).filter(function (part) {
    return part.getBoundingClientRect().bottom <= innerHeight;
  }).map(function (part) { return part.textContent; }).join('\n');
  report.wide_px = document.documentElement.scrollWidth - document.documentElement.clientWidth;
  var view = document.querySelector('#view3d canvas');
  if (view) {
    var before = pixelsOf(view, view.width, view.height);
    var ground = before.slice();
    for (var i = 0; i < ground.length; ++i) ground[i] = before[i % 4];
    report.view_filled = differing(before, ground);
    var box = view.getBoundingClientRect(), x = box.left + box.width / 2, y = box.top + box.height / 2;
    function mouse(type, on, dx) {
      on.dispatchEvent(new MouseEvent(type, { bubbles: true, cancelable: true, button: 0, clientX: x + dx, clientY: y }));
    }
    mouse('mousedown', view, 0);
    for (var dx = 10; dx <= 150; dx += 10) mouse('mousemove', document, dx);
    mouse('mouseup', document, 150);
    report.view_turned = differing(before, pixelsOf(view, view.width, view.height));
    report.views = {};
    for (var one of document.querySelectorAll('.buttons button')) {
      one.click();
        var now = pixelsOf(view, view.width, view.height);
      report.views[one.textContent] = differing(now, ground);
    }
  }
  report.pictures = [];
  for (var picture of document.querySelectorAll('img, svg image')) {
    var shown = pixelsOf(picture, 320, 240), first = shown.slice();
    for (var k = 0; k < first.length; ++k) first[k] = shown[k % 4];
    report.pictures.push(differing(shown, first));
  }
  report.plots = document.querySelectorAll('svg.plot').length;
  report.done = true;
  tell();
});
</script></body>)";
  page.replace(page.find("<head>"), 6, begin);
  page.replace(page.rfind("</body>"), 7, end);
  return page;
}

/// A page that holds another one in a frame of this size, and what its harness says.
inline std::string frame_of(const std::string& file, int width, int height) {
  return "<!DOCTYPE html><html><body><script>addEventListener('message', function (e) { "
         "document.getElementById('harness').textContent = e.data; });</script><iframe src=\"" +
         file + "\" width=\"" + std::to_string(width) + "\" height=\"" + std::to_string(height) +
         "\" style=\"border:0\"></iframe><pre id=\"harness\"></pre></body></html>";
}

}  // namespace rigcal
