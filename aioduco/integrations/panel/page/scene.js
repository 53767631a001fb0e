addEventListener("keydown", (event) => { if (event.key === "Escape") parent.postMessage("Escape", "*"); }, true);

// Without a graphics processor each picture takes the processors on which stop and state run too. It is
// then drawn five times a second, all that is due at a time together.
(() => {
  const gl = document.createElement("canvas").getContext("webgl");
  const known = gl && gl.getExtension("WEBGL_debug_renderer_info");
  const name = known ? gl.getParameter(known.UNMASKED_RENDERER_WEBGL) : "";
  gl?.getExtension("WEBGL_lose_context")?.loseContext();
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
