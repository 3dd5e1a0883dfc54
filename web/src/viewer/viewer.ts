import { Color, ColorManagement, LinearSRGBColorSpace, WebGLRenderer } from 'three';
import { LabelPainter } from './labels.ts';
import { Pace } from './pace.ts';
import type { View } from './view.ts';

// Colours are those of the screen throughout: legends and surfaces must show the same ones, and blending needs no light of physics.
ColorManagement.enabled = false;

/** So long after the last change of a motion the picture is drawn in full. */
const SETTLE_MILLISECONDS = 120;

/**
 * Draws several views with one renderer, each into the part of the canvas that its element covers. A picture is drawn only when
 * something has changed.
 */
export class Viewer {
  readonly canvas = document.createElement('canvas');
  readonly views: View[] = [];
  /** Between the views. */
  readonly gap = new Color(0x808080);
  /** Called after each picture with the milliseconds that it took. */
  onFrame: ((milliseconds: number) => void) | null = null;
  private readonly host: HTMLElement;
  private readonly renderer: WebGLRenderer;
  private readonly labels: LabelPainter;
  private readonly observer: ResizeObserver;
  private requested = 0;
  private settleTimer = 0;
  private moving = false;
  private readonly pace = new Pace();

  constructor(host: HTMLElement) {
    this.host = host;
    this.canvas.className = 'viewer-canvas';
    host.prepend(this.canvas);
    const software = drawsInSoftware();
    const attributes: WebGLContextAttributes = {
      alpha: false,
      antialias: !software,
      powerPreference: 'high-performance',
      // Views that did not change keep their pixels and are not drawn again.
      preserveDrawingBuffer: true,
    };
    // An opaque canvas need not be blended with the page, which the renderer does not offer by itself.
    const context = this.canvas.getContext('webgl2', attributes);
    if (!context) throw new Error('this browser has no WebGL 2, which the studio draws with');
    this.renderer = new WebGLRenderer({ canvas: this.canvas, context });
    const ratio = software ? 1 : Math.min(devicePixelRatio, 2);
    this.renderer.setPixelRatio(ratio);
    this.labels = new LabelPainter(ratio);
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.setScissorTest(true);
    this.renderer.autoClear = false;
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(host);
    this.canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    this.canvas.addEventListener('webglcontextrestored', () => this.invalidate());
  }

  addView(view: View): void {
    this.views.push(view);
    this.observer.observe(view.element);
    this.invalidate();
  }

  removeView(view: View): void {
    this.observer.unobserve(view.element);
    const index = this.views.indexOf(view);
    if (index >= 0) this.views.splice(index, 1);
    this.invalidate();
  }

  /**
   * Asks for a picture of all views, or of some. `moving` says that more will follow soon, so what is dear waits until they rest.
   */
  invalidate(moving = false, views: readonly View[] = this.views): void {
    if (views.length === 0) return;
    for (const view of views) view.dirty = true;
    if (moving) {
      this.moving = true;
      window.clearTimeout(this.settleTimer);
      this.settleTimer = window.setTimeout(() => this.settle(), SETTLE_MILLISECONDS);
    }
    if (!this.requested) this.requested = requestAnimationFrame((now) => this.draw(now));
  }

  dispose(): void {
    cancelAnimationFrame(this.requested);
    window.clearTimeout(this.settleTimer);
    this.observer.disconnect();
    this.labels.dispose();
    this.renderer.dispose();
    this.canvas.remove();
  }

  private settle(): void {
    this.moving = false;
    this.invalidate(
      false,
      this.views.filter((view) => view.hurried),
    );
  }

  private draw(now: number): void {
    this.requested = 0;
    const start = performance.now();
    const bounds = this.host.getBoundingClientRect();
    if (this.views.every((view) => view.dirty)) this.clearGaps(bounds);
    const flying: View[] = [];
    const measured = this.moving && this.pace.wants(this.views.reduce((sum, view) => sum + view.changes, 0));
    const coarse = this.moving && !measured && this.pace.slow;
    for (const view of this.views) {
      if (!view.dirty) continue;
      const box = view.element.getBoundingClientRect();
      if (box.width < 2 || box.height < 2) continue;
      view.width = box.width;
      view.height = box.height;
      view.advance(now);
      view.setCoarse(coarse);
      if (view.flying) flying.push(view);
      view.dirty = false;
      view.hurried = this.moving;
      const left = box.left - bounds.left;
      const top = box.top - bounds.top;
      // WebGL counts rows from the bottom.
      const bottom = bounds.height - top - box.height;
      this.renderer.setViewport(left, bottom, box.width, box.height);
      this.renderer.setScissor(left, bottom, box.width, box.height);
      this.renderer.setClearColor(view.background, 1);
      this.renderer.clear();
      this.renderer.render(view.scene, view.camera);
      this.labels.draw(this.renderer, view, !this.moving);
    }
    if (measured) this.pace.add(this.finish(start));
    this.onFrame?.(performance.now() - start);
    this.invalidate(true, flying);
  }

  private clearGaps(bounds: DOMRect): void {
    this.renderer.setViewport(0, 0, bounds.width, bounds.height);
    this.renderer.setScissor(0, 0, bounds.width, bounds.height);
    this.renderer.setClearColor(this.gap, 1);
    this.renderer.clear();
  }

  /** The milliseconds since `start` when the picture is done; reading a pixel waits for that. */
  private finish(start: number): number {
    const context = this.renderer.getContext();
    context.readPixels(0, 0, 1, 1, context.RGBA, context.UNSIGNED_BYTE, new Uint8Array(4));
    return performance.now() - start;
  }

  private resize(): void {
    const width = Math.max(this.host.clientWidth, 1);
    const height = Math.max(this.host.clientHeight, 1);
    for (const view of this.views) view.dirty = true;
    const ratio = this.renderer.getPixelRatio();
    if (this.canvas.width === Math.floor(width * ratio) && this.canvas.height === Math.floor(height * ratio)) {
      this.invalidate();
      return;
    }
    this.renderer.setSize(width, height, false);
    // A resized canvas is empty until the next picture, which must not wait for the one after.
    this.draw(performance.now());
  }
}

/** Whether WebGL is drawn by the processor, where smoothing of edges costs most of the time of a picture. */
function drawsInSoftware(): boolean {
  const context = document.createElement('canvas').getContext('webgl2');
  if (!context) throw new Error('this browser has no WebGL 2, which the studio draws with');
  const info = context.getExtension('WEBGL_debug_renderer_info');
  const name = info ? String(context.getParameter(info.UNMASKED_RENDERER_WEBGL)) : '';
  context.getExtension('WEBGL_lose_context')?.loseContext();
  return /swiftshader|llvmpipe|software|basic render/i.test(name);
}
