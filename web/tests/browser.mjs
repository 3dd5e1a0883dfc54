// Chromium with graphics in software, and pages in it.
import { join } from 'node:path';
import { after, before } from 'node:test';
import { chromium } from 'playwright-core';
import { serve } from './servers.mjs';

const SOFTWARE_GRAPHICS = ['--use-gl=angle', '--use-angle=swiftshader', '--enable-unsafe-swiftshader'];

export async function launch() {
  return chromium.launch({
    executablePath: process.env.CHROMIUM ?? '/usr/bin/chromium',
    // Chromium takes a page that a test puts in for a foreign one, which may not talk to this machine.
    args: [...SOFTWARE_GRAPHICS, '--no-sandbox', '--disable-features=LocalNetworkAccessChecks'],
  });
}

/** One browser and one server for all tests of a file; the options are those of `serve`. */
export function studioOfFile(options) {
  const studio = {
    browser: null,
    server: null,
    /** A page of the server that has loaded both meshes. */
    open: (more) => openPage(studio.browser, studio.server.url, more),
  };
  before(async () => {
    [studio.browser, studio.server] = await Promise.all([launch(), serve(options)]);
  });
  after(async () => {
    await studio.browser?.close();
    await studio.server?.close();
  });
  return studio;
}

/** A page that has loaded both meshes, at the size of a laptop. What goes wrong in it is in `page.errors`. */
export async function openPage(browser, url, { theme = 'light', ready = true, before = async () => {} } = {}) {
  const page = await browser.newPage({ viewport: { width: 1280, height: 720 }, colorScheme: theme });
  page.errors = [];
  page.on('pageerror', (error) => page.errors.push(String(error)));
  page.on('console', (message) => message.type() === 'error' && page.errors.push(message.text()));
  await before(page);
  await page.goto(url);
  if (process.env.MIMESH_PAGE) await showBuiltPage(page);
  if (ready) await loaded(page);
  return page;
}

/** The page in the folder MIMESH_PAGE takes the place of that in the program, which then need not be built anew. */
async function showBuiltPage(page) {
  const isOfPage = ({ pathname }) => !pathname.startsWith('/api/');
  await page.route(isOfPage, (route) => {
    const { pathname } = new URL(route.request().url());
    return route.fulfill({ path: join(process.env.MIMESH_PAGE, pathname === '/' ? 'index.html' : pathname) });
  });
  await page.goto(new URL('/', page.url()).href);
}

/** Waits until both meshes are there, and a frame of the target. */
export async function loaded(page) {
  await page.waitForFunction(
    () => window.mimesh?.studio.phase.peek().name === 'ready' && window.mimesh.studio.live.target.peek(),
  );
  // Cameras are where the first picture puts them.
  await page.evaluate(() => new Promise((drawn) => requestAnimationFrame(() => requestAnimationFrame(drawn))));
}

export function pairs(page) {
  return page.evaluate(() => window.mimesh.studio.markers.pairs.peek());
}

/** The first pair that a page has for which `test` holds. */
export async function pairWith(page, test) {
  return (await pairs(page)).find(test);
}

/** Waits until the server has every edit. */
export async function saved(page) {
  await page.evaluate(() => window.mimesh.studio.markers.settled());
}

/** Waits until no camera flies, so that a place on the screen stays. */
export async function atRest(page) {
  await page.waitForFunction(() => window.mimesh.stage.panes.peek().every((pane) => !pane.view.flying));
}
