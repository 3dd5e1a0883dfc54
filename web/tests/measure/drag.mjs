// A drag: from the hand to the picture.
import { pointOnScreen } from '../places.mjs';

/** Milliseconds from a move of the mouse to the end of the picture of the target that it made, for `count` pictures of one drag. */
export async function dragAbout(page, count) {
  const id = await page.evaluate(
    () => window.mimesh.studio.markers.pairs.peek().find((pair) => pair.source && pair.target).id,
  );
  const { x, y } = await pointOnScreen(page, 'result', id);
  await page.evaluate(() => {
    const { studio, stage } = window.mimesh;
    const gl = stage.viewer.canvas.getContext('webgl2');
    window.latencies = [];
    window.ofServer = [];
    let moved = null;
    let due = null;
    document.addEventListener(
      'pointermove',
      (event) => {
        moved ??= { time: event.timeStamp, drag: studio.live.target.peek().header.drag ?? 0 };
      },
      true,
    );
    const receive = studio.live.receive.bind(studio.live);
    studio.live.receive = (frame) => {
      receive(frame);
      if (moved && frame.header.drag !== null && frame.header.drag > moved.drag) {
        due = moved.time;
        window.ofServer.push(frame.header.milliseconds);
        moved = null;
      }
    };
    stage.viewer.onFrame = () => {
      if (due === null) return;
      gl.readPixels(0, 0, 1, 1, gl.RGBA, gl.UNSIGNED_BYTE, new Uint8Array(4));
      window.latencies.push(performance.now() - due);
      due = null;
    };
  });
  const body = await page.evaluate(middleOfMesh);
  await page.mouse.move(x, y);
  await page.mouse.down();
  for (let i = 1; (await page.evaluate(() => window.latencies.length)) < count; i++) {
    if (i > 20 * count) throw new Error('pictures do not follow the drag');
    await page.mouse.move(body.x + 12 * Math.sin(i / 5), body.y + 8 * Math.cos(i / 5));
    await page.waitForTimeout(60);
  }
  await page.mouse.up();
  return page.evaluate(() => ({ latencies: window.latencies, ofServer: window.ofServer }));
}

/** A place of the target that has mesh all around it. */
function middleOfMesh() {
  const pane = window.mimesh.stage.panes.peek().at(-1);
  const box = pane.surfaceElement.getBoundingClientRect();
  const around = [-16, 0, 16];
  for (let y = box.height / 2; y > 0; y -= 8) {
    for (let x = box.width / 2; x < box.width; x += 8) {
      if (around.every((dx) => around.every((dy) => pane.pick(x + dx, y + dy))))
        return { x: box.left + x, y: box.top + y };
    }
  }
  throw new Error('no place');
}
