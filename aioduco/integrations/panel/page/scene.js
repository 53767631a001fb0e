addEventListener("keydown", (event) => { if (event.key === "Escape") parent.postMessage("Escape", "*"); }, true);

// The page covers the picture until a body of the arm was drawn: of hundreds of triangles, as nothing
// else is that viser draws before.
(() => {
  const drawing = window.WebGL2RenderingContext && WebGL2RenderingContext.prototype;
  if (!drawing) return;
  const draw = drawing.drawElements;
  drawing.drawElements = function (mode, count, ...rest) {
    draw.call(this, mode, count, ...rest);
    if (count < 1000) return;
    drawing.drawElements = draw;
    requestAnimationFrame(() => parent.postMessage("drawn", "*"));
  };
})();

// Without a graphics processor each picture takes the processors on which stop and state run too. It is
// then drawn five times a second, all that is due at a time together.
(() => {
  const gl = document.createElement("canvas").getContext("webgl");
  const known = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const name = known ? gl.getParameter(known.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
  if (!gl) parent.postMessage("no WebGL", "*");
  if (!/swiftshader|llvmpipe|softpipe|software|basic render/i.test(name)) return;
  const period = 200; // ms
  const next = window.requestAnimationFrame.bind(window);
  const waiting = new Map();
  let last = 0;
  let timer = null;
  window.requestAnimationFrame = (draw) => {
    waiting.set(++last, draw);
    timer ??= setTimeout(() => next((now) => {
      timer = null;
      const due = [...waiting.values()];
      waiting.clear();
      for (const each of due) {
        try { each(now); } catch (error) { reportError(error); }
      }
    }), period - performance.now() % period);
    return last;
  };
  window.cancelAnimationFrame = (number) => { waiting.delete(number); };
})();
