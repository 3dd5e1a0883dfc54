import { ColorManagement, LinearSRGBColorSpace, WebGLRenderer } from 'three';
import { drawLabels } from './labels.ts';
import { View } from './view.ts';

// Colours are those of the screen throughout: legends and surfaces must show the same ones, and blending needs no light of physics.
ColorManagement.enabled = false;

/**
 * Draws several views with one renderer, each into the part of the canvas that its element covers. A picture is drawn only when
 * something has changed.
 */
export class Viewer {
  readonly canvas = document.createElement('canvas');
  readonly overlay = document.createElement('canvas');
  readonly views: View[] = [];
  /** Called after each picture with the milliseconds that it took. */
  onFrame: ((milliseconds: number) => void) | null = null;
  private readonly host: HTMLElement;
  private readonly renderer: WebGLRenderer;
  private readonly context: CanvasRenderingContext2D;
  private readonly observer: ResizeObserver;
  private requested = 0;
  private settleTimer = 0;
  private moving = false;

  constructor(host: HTMLElement) {
    this.host = host;
    this.canvas.className = 'viewer-canvas';
    this.overlay.className = 'viewer-overlay';
    host.prepend(this.canvas, this.overlay);
    const software = drawsInSoftware();
    this.renderer = new WebGLRenderer({
      canvas: this.canvas,
      antialias: !software,
      powerPreference: 'high-performance',
      // The picture is read back only by those who ask for it right after drawing.
      preserveDrawingBuffer: false,
    });
    this.renderer.setPixelRatio(software ? 1 : Math.min(devicePixelRatio, 2));
    this.renderer.outputColorSpace = LinearSRGBColorSpace;
    this.renderer.setScissorTest(true);
    this.renderer.autoClear = false;
    const context = this.overlay.getContext('2d');
    if (!context) throw new Error('this browser cannot draw on a canvas');
    this.context = context;
    this.observer = new ResizeObserver(() => this.resize());
    this.observer.observe(host);
    this.canvas.addEventListener('webglcontextlost', (event) => event.preventDefault());
    this.canvas.addEventListener('webglcontextrestored', () => this.invalidate());
  }

  addView(element: HTMLElement): View {
    const view = new View(element);
    this.views.push(view);
    this.observer.observe(element);
    this.invalidate();
    return view;
  }

  removeView(view: View): void {
    this.observer.unobserve(view.element);
    this.views.splice(this.views.indexOf(view), 1);
    this.invalidate();
  }

  /** Asks for a picture. `moving` says that more will follow soon, so what is dear waits until it rests. */
  invalidate(moving = false): void {
    if (moving) {
      this.moving = true;
      window.clearTimeout(this.settleTimer);
      this.settleTimer = window.setTimeout(() => {
        this.moving = false;
        this.invalidate();
      }, 120);
    }
    if (!this.requested) this.requested = requestAnimationFrame((now) => this.draw(now));
  }

  dispose(): void {
    cancelAnimationFrame(this.requested);
    window.clearTimeout(this.settleTimer);
    this.observer.disconnect();
    this.renderer.dispose();
    this.canvas.remove();
    this.overlay.remove();
  }

  private draw(now: number): void {
    this.requested = 0;
    const start = performance.now();
    const bounds = this.host.getBoundingClientRect();
    this.context.setTransform(1, 0, 0, 1, 0, 0);
    this.context.clearRect(0, 0, this.overlay.width, this.overlay.height);
    let flying = false;
    for (const view of this.views) {
      const box = view.element.getBoundingClientRect();
      if (box.width < 2 || box.height < 2) continue;
      view.width = box.width;
      view.height = box.height;
      view.advance(now);
      flying ||= view.flying;
      const left = box.left - bounds.left;
      const top = box.top - bounds.top;
      // WebGL counts rows from the bottom.
      const bottom = bounds.height - top - box.height;
      this.renderer.setViewport(left, bottom, box.width, box.height);
      this.renderer.setScissor(left, bottom, box.width, box.height);
      this.renderer.setClearColor(view.background, 1);
      this.renderer.clear();
      this.renderer.render(view.scene, view.camera);
      this.drawOverlay(view, left, top);
    }
    this.onFrame?.(performance.now() - start);
    if (flying) this.invalidate(true);
  }

  private drawOverlay(view: View, left: number, top: number): void {
    const ratio = this.overlay.width / Math.max(this.host.clientWidth, 1);
    this.context.save();
    this.context.setTransform(ratio, 0, 0, ratio, left * ratio, top * ratio);
    this.context.beginPath();
    this.context.rect(0, 0, view.width, view.height);
    this.context.clip();
    drawLabels(this.context, view, !this.moving);
    this.context.restore();
  }

  private resize(): void {
    const width = Math.max(this.host.clientWidth, 1);
    const height = Math.max(this.host.clientHeight, 1);
    this.renderer.setSize(width, height, false);
    this.overlay.width = Math.round(width * Math.min(devicePixelRatio, 2));
    this.overlay.height = Math.round(height * Math.min(devicePixelRatio, 2));
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
