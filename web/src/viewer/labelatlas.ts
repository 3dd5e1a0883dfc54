import { CanvasTexture, LinearFilter } from 'three';
import type { Label } from './label.ts';

/** The size of the picture of one label, in pixels of the page; its dot lies at `DOT_X`, `DOT_Y`. */
export const CELL_WIDTH = 64;
export const CELL_HEIGHT = 44;
export const DOT_X = 16;
export const DOT_Y = 30;
export const TAG_OFFSET = 13;
const DOT = 4.5;
const COLUMNS = 16;
const ROWS = 32;

/** Pictures of labels in one texture. A picture is drawn once for each look that occurs, not for each frame. */
export class LabelAtlas {
  readonly texture: CanvasTexture;
  private readonly context: CanvasRenderingContext2D;
  private readonly ratio: number;
  private readonly cells = new Map<string, number>();

  constructor(ratio: number) {
    this.ratio = ratio;
    const canvas = document.createElement('canvas');
    canvas.width = CELL_WIDTH * COLUMNS * ratio;
    canvas.height = CELL_HEIGHT * ROWS * ratio;
    const context = canvas.getContext('2d', { willReadFrequently: true });
    if (!context) throw new Error('this browser cannot draw on a canvas');
    this.context = context;
    this.texture = new CanvasTexture(canvas);
    this.texture.flipY = false;
    // Soft edges keep their colour only if colours are weighted before they are mixed.
    this.texture.premultiplyAlpha = true;
    this.texture.generateMipmaps = false;
    this.texture.minFilter = LinearFilter;
    this.texture.magFilter = LinearFilter;
  }

  /** The column and row of a label's picture. */
  cell(label: Label): [number, number] {
    const key = `${label.text}|${label.colour}|${label.hollow}|${label.selected || label.hovered}`;
    let index = this.cells.get(key);
    if (index === undefined) {
      // A full atlas begins anew; whatever is still on the screen is drawn again as it is asked for.
      if (this.cells.size === COLUMNS * ROWS) this.cells.clear();
      index = this.cells.size;
      this.cells.set(key, index);
      this.draw(label, index % COLUMNS, Math.floor(index / COLUMNS));
      this.texture.needsUpdate = true;
    }
    return [index % COLUMNS, Math.floor(index / COLUMNS)];
  }

  get grid(): [number, number] {
    return [COLUMNS, ROWS];
  }

  private draw(label: Label, column: number, row: number): void {
    const { context, ratio } = this;
    context.setTransform(ratio, 0, 0, ratio, column * CELL_WIDTH * ratio, row * CELL_HEIGHT * ratio);
    context.clearRect(0, 0, CELL_WIDTH, CELL_HEIGHT);
    drawDot(context, label);
    drawTag(context, label);
  }
}

function drawDot(context: CanvasRenderingContext2D, label: Label): void {
  if (label.selected || label.hovered) {
    circle(context, DOT + 5);
    context.strokeStyle = '#fff';
    context.lineWidth = 4;
    context.stroke();
    context.strokeStyle = label.colour;
    context.lineWidth = 2;
    context.stroke();
  }
  circle(context, DOT);
  context.fillStyle = label.hollow ? '#fff' : label.colour;
  context.fill();
  context.lineWidth = label.hollow ? 2.5 : 1.5;
  context.strokeStyle = label.hollow ? label.colour : '#fff';
  context.stroke();
}

function circle(context: CanvasRenderingContext2D, radius: number): void {
  context.beginPath();
  context.arc(DOT_X, DOT_Y, radius, 0, 2 * Math.PI);
}

function drawTag(context: CanvasRenderingContext2D, label: Label): void {
  context.font = '600 11px system-ui, "DejaVu Sans", sans-serif';
  context.textAlign = 'center';
  context.textBaseline = 'middle';
  const width = Math.max(context.measureText(label.text).width + 9, 18);
  const [x, y] = [DOT_X + TAG_OFFSET, DOT_Y - TAG_OFFSET];
  context.beginPath();
  context.roundRect(x - width / 2, y - 8, width, 16, 8);
  context.fillStyle = label.hollow ? '#fff' : label.colour;
  context.fill();
  context.lineWidth = 1.5;
  context.strokeStyle = label.hollow ? label.colour : '#ffffffd0';
  context.stroke();
  context.fillStyle = label.hollow ? '#1a1d21' : '#fff';
  context.fillText(label.text, x, y + 0.5);
}
