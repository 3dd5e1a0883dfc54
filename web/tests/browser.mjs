// Chromium with graphics in software, and a server: the mock, or the program at MIMESH_STUDIO_URL (with its token).
import { fileURLToPath } from 'node:url';
import { chromium } from 'playwright-core';
import { MockServer } from './mock/server.mjs';

export async function launch() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    args: ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader', '--no-sandbox'],
  });
}

/** The address of a server and what ends it. Options are those of the mock; the program has its own. */
export async function serve(options = {}) {
  if (process.env.MIMESH_STUDIO_URL) return { url: process.env.MIMESH_STUDIO_URL, mock: null, close: async () => {} };
  const mock = new MockServer({ dist: fileURLToPath(new URL('../dist', import.meta.url)), ...options });
  return { url: await mock.listen(), mock, close: () => mock.close() };
}

/** A page that has loaded both meshes, at the size of a laptop. */
export async function openPage(browser, url, { theme = 'light', ready = true } = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 }, colorScheme: theme });
  page.errors = [];
  page.on('pageerror', (error) => page.errors.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && page.errors.push(message.text()));
  await page.goto(url);
  if (ready)
    await page.waitForFunction(
      () => window.mimesh?.studio.phase.peek().name === 'ready' && window.mimesh.studio.live.target.peek(),
    );
  return page;
}

/** Where the point of a pair is on the screen; the pane is `source`, `rest` or `result`. */
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
