import type { MarkerStore } from '../markers/store.ts';
import type { Painting, ServerSteps } from '../paint/painting.ts';
import type { Socket } from '../protocol/socket.ts';
import type { PipelineStore } from '../stages/store.ts';
import { notify } from '../ui/notices.ts';
import { effect } from '../ui/signal.ts';
import { past } from './past.ts';

/** What has steps: points, settings and strokes of the brush. */
interface Steps {
  markers: MarkerStore;
  pipeline: PipelineStore;
  painting: Painting;
  socket: Socket;
}

interface Due {
  title: string;
  of: 'markers' | 'pipeline' | 'painting';
  /** Of two steps the one with the larger number was done later. */
  order: number;
}

/** One history over points, settings and strokes: what was done last is undone first, whatever it was. */
export class Undo {
  /** Called when a step of the points was taken back or done again, with the pairs that this brought back. */
  onReturned: (pairs: number[]) => void = () => {};
  /** Called when a stroke was taken back or made again, so that it is seen. */
  onStroke: () => void = () => {};
  private readonly studio: Steps;
  private chain: Promise<void> = Promise.resolve();
  private highest = 0;

  constructor(studio: Steps) {
    this.studio = studio;
    studio.painting.steps = () => this.serverSteps();
    effect(() => {
      const { undo_order: ofMarkers } = studio.markers.document.value;
      const ofPipeline = studio.pipeline.pipeline.value?.undo_order ?? null;
      const newest = Math.max(ofMarkers ?? 0, ofPipeline ?? 0);
      if (newest > this.highest) studio.painting.endFuture();
      this.highest = Math.max(this.highest, newest);
    });
  }

  /** Another project or another server: its steps have numbers of their own. */
  rebase(): void {
    this.highest = 0;
    this.studio.painting.rebase();
  }

  /** Takes back the last step, or does one again, after those that are under way. */
  step(redo: boolean): Promise<void> {
    this.chain = this.chain.then(() => this.one(redo));
    return this.chain;
  }

  /** The step that is due: the newest that is done, or the oldest that was taken back. */
  due(redo: boolean): Due | null {
    const { markers, pipeline, painting } = this.studio;
    const stroke = painting.due(redo);
    const steps = [
      serverStep('markers', markers.document.value, redo),
      serverStep('pipeline', pipeline.pipeline.value, redo),
    ].filter((step) => step !== null && !(redo && painting.hasEnded(step.order)));
    const all = [...steps, stroke && { ...stroke, of: 'painting' as const }].filter((step) => step !== null);
    return all.sort((a, b) => (redo ? a.order - b.order : b.order - a.order))[0] ?? null;
  }

  private async one(redo: boolean): Promise<void> {
    const { markers, pipeline, painting, socket } = this.studio;
    const stroke = painting.due(redo);
    const isStroke = () => this.due(redo)?.of === 'painting';
    if (!redo && socket.connection.peek() !== 'open') {
      const isLast = stroke !== null && stroke.order > this.serverSteps().done;
      if (!isLast && markers.dropUnsent()) return say('Undid the last change, which was not sent yet.');
    }
    // A stroke needs no server, but what is under way may have been done after it.
    if (!isStroke() || socket.connection.peek() === 'open') await Promise.all([markers.settled(), pipeline.settled()]);
    const due = this.due(redo);
    if (due === null) return say(redo ? 'There is nothing to redo.' : 'There is nothing to undo.');
    if (await this.take(due, redo)) say(`${redo ? 'Did again' : 'Undid'}: ${past(due.title)}.`);
  }

  private async take({ of }: Due, redo: boolean): Promise<boolean> {
    const { markers, pipeline, painting } = this.studio;
    if (of === 'pipeline') return pipeline.step(redo);
    if (of === 'painting') {
      painting.step(redo);
      this.onStroke();
      return true;
    }
    const before = new Set(markers.pairs.peek().map((pair) => pair.id));
    const done = await markers.step(redo);
    this.onReturned(
      markers.pairs
        .peek()
        .map((pair) => pair.id)
        .filter((id) => !before.has(id)),
    );
    return done;
  }

  /** Changes that are under way become steps, too. */
  private serverSteps(): ServerSteps {
    const { markers, pipeline } = this.studio;
    const { undo_order: ofMarkers, redo_order } = markers.document.peek();
    const settings = pipeline.pipeline.peek();
    const waiting = markers.waiting.peek() + (pipeline.saving.peek() ? 1 : 0);
    const done = Math.max(ofMarkers ?? 0, settings?.undo_order ?? 0) + waiting;
    return { done, highest: Math.max(this.highest, done, redo_order ?? 0, settings?.redo_order ?? 0) };
  }
}

interface Titles {
  undo: string | null;
  undo_order: number | null;
  redo: string | null;
  redo_order: number | null;
}

function serverStep(of: 'markers' | 'pipeline', document: Titles | null, redo: boolean): Due | null {
  const title = redo ? document?.redo : document?.undo;
  const order = redo ? document?.redo_order : document?.undo_order;
  return title === null || title === undefined ? null : { title, of, order: order ?? 0 };
}

function say(text: string): void {
  notify(text, null, 'info', 'undo');
}
