// The first picture of both meshes, and pictures while a view is turned. These functions run in the page.

/** Waits for the first picture with both meshes to be done, which reading a pixel does. */
export function watchFirstPicture() {
  const timer = setInterval(() => {
    const { studio, stage } = window.mimesh ?? {};
    if (!studio?.meshes.peek()) return;
    clearInterval(timer);
    stage.viewer.onFrame = () => {
      if (!stage.panes.peek().every((pane) => pane.surface) || studio.phase.peek().name !== 'ready') return;
      stage.viewer.onFrame = null;
      const gl = stage.viewer.canvas.getContext('webgl2');
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      window.firstPicture = performance.now();
    };
    stage.viewer.invalidate();
  }, 5);
}

/** Milliseconds of pictures while the view is turned, each timed to its end. */
export async function turn(count) {
  const { stage } = window.mimesh;
  const gl = stage.viewer.canvas.getContext('webgl2');
  const pane = stage.panes.peek()[0];
  const times = [];
  for (let i = 0; i < count; i++) {
    const start = performance.now();
    await new Promise((resolve) => {
      stage.viewer.onFrame = () => {
        gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
        resolve();
      };
      stage.camera.turn(pane, 4, 0);
    });
    times.push(performance.now() - start);
  }
  stage.viewer.onFrame = null;
  return times;
}
