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

/** A complete pair in sight, with mesh below all of the way by which a hand will drag it. */
export function draggable(page, pane, [dx, dy]) {
  return page.evaluate(
    ([role, x, y]) => {
      const { studio, stage } = window.mimesh;
      const found = stage.panes.peek().find((other) => other.role === role);
      const fits = (label) => {
        const { source, target } = studio.markers.pair(label.id);
        if (!source || !target || found.view.occluded(label)) return false;
        const [u, v] = found.view.project(label.position);
        const steps = [0, 0.25, 0.5, 0.75, 1];
        return steps.every((share) => found.pick(u + share * x, v + share * y));
      };
      const label = found.view.labels.find(fits);
      if (!label) throw new Error('no pair lies where it can be dragged');
      return studio.markers.pair(label.id);
    },
    [pane, dx, dy],
  );
}
