// Where on the screen a hand has to go.

/** Where the point of a pair is; the pane is `source`, `rest` or `result`. */
export function pointOnScreen(page, pane, pair) {
  return page.evaluate(
    ([role, id]) => {
      const { studio, stage } = window.mimesh;
      const found = stage.panes.peek().find((other) => other.role === role);
      const place = found.locate(studio.markers.pair(id)[found.side]);
      const box = found.surfaceElement.getBoundingClientRect();
      const [x, y] = found.view.project(place.position);
      return { x: box.left + x, y: box.top + y };
    },
    [pane, pair],
  );
}

/** A place of the mesh in a pane that no label covers, the nearest to the middle. */
export function freePlace(page, pane) {
  return page.evaluate((role) => {
    const found = window.mimesh.stage.panes.peek().find((other) => other.role === role);
    const box = found.surfaceElement.getBoundingClientRect();
    for (let ring = 0; ring < 200; ring += 6) {
      for (let angle = 0; angle < 6.28; angle += 0.5) {
        const [x, y] = [box.width / 2 + ring * Math.cos(angle), box.height / 2 + ring * Math.sin(angle)];
        const free = found.view.labels.every((label) => {
          const [u, v] = found.view.project(label.position) ?? [-1e3, -1e3];
          return Math.hypot(u - x, v - y) > 40;
        });
        if (free && found.pick(x, y)) return { x: box.left + x, y: box.top + y };
      }
    }
    throw new Error('no free place');
  }, pane);
}
