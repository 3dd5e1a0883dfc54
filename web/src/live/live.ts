import { type Container, floats } from '../protocol/container.ts';
import type { Socket } from '../protocol/socket.ts';
import type {
  Ahead,
  Channel,
  FrameHeader,
  FrameScalar,
  LiveState,
  Point,
  PoseRef,
  Side,
  Worst,
} from '../protocol/types.ts';
import { computed, effect, signal } from '../ui/signal.ts';
import { playableStep, preparation } from './ahead.ts';
import { replaces } from './frames.ts';

export interface Shown {
  header: FrameHeader;
  positions: Float32Array;
  values: Float32Array | null;
  scalar: FrameScalar | null;
}

/** A page that waits for frames that never come asks again after so long. */
const PATIENCE_MILLISECONDS = 400;

/** What the page shows of the motion: it asks the server for the present pose, and holds the newest frame of each mesh. */
export class Live {
  readonly pose = signal<PoseRef>(null);
  readonly scalar = signal<string | null>(null);
  /** Whether some view shows the truth. */
  readonly wantsTruth = signal(false);
  readonly playing = signal(false);
  /** Results of frames that the server has computed ahead. */
  readonly ahead = signal<Ahead | null>(null);
  /** The revisions of points and settings. */
  readonly revisions = signal({ markers: 0, pipeline: 0 });
  /** How far apart the frames lie whose results can be played; null while the rough preview is all that can. */
  readonly playable = computed(() => playableStep(this.ahead.value, this.present()));
  readonly source = signal<Shown | null>(null);
  readonly target = signal<Shown | null>(null);
  readonly truth = signal<Shown | null>(null);
  readonly states = signal<Partial<Record<LiveState['channel'], LiveState>>>({});
  readonly worst = signal<Worst[]>([]);
  /** A place that is shown as soon as it is known. */
  readonly sought = signal<{ metric: string; pose: number | null } | null>(null);
  /** From the last drag that was sent to its picture, in milliseconds. */
  readonly latency = signal<number | null>(null);
  private readonly socket: Socket;
  private project = -1;
  /** Of the frame of the target that is shown; null if any other one may take its place. */
  private stamp: FrameHeader | null = null;
  private look = 0;
  private answered = 0;
  private lookSent = 0;
  private lookDue = false;
  private drag = 0;
  private dragAnswered = 0;
  private dragSent = 0;
  private nextDrag: { pair: number; side: Side; point: Point } | null = null;
  private timer = 0;

  constructor(socket: Socket) {
    this.socket = socket;
    effect(() => {
      void [this.pose.value, this.scalar.value, this.wantsTruth.value, this.playing.value, this.playable.value];
      this.ask();
    });
  }

  /** Another project: nothing that is shown holds any more. */
  open(project: number): void {
    this.project = project;
    this.pose.value = null;
    this.scalar.value = null;
    this.playing.value = false;
    this.stamp = null;
    this.source.value = null;
    this.target.value = null;
    this.truth.value = null;
    this.worst.value = [];
    this.sought.value = null;
    this.ahead.value = null;
    this.states.value = {};
    this.ask();
  }

  /** Asks for frames of what is to be seen now; while an answer is under way, only the newest wish waits. */
  ask(): void {
    if (this.project < 0) return;
    if (this.waitsForLook()) {
      this.lookDue = true;
      this.later();
      return;
    }
    this.lookDue = false;
    // The slow result of each frame would only delay the motion; those that were computed ahead need no preview.
    const [playing, playable] = [this.playing.peek(), this.playable.value !== null];
    const channels: Channel[] = ['source'];
    if (!playing || !playable) channels.push('preview');
    if (!playing || playable) channels.push('result');
    if (this.wantsTruth.peek()) channels.push('truth');
    this.look += 1;
    this.lookSent = performance.now();
    this.socket.send({
      type: 'look',
      look: this.look,
      pose: this.pose.peek(),
      channels,
      scalar: this.scalar.peek(),
      ahead: true,
    });
  }

  /** What is missing before results can be played. */
  preparation(): string {
    return preparation(this.ahead.value, this.present());
  }

  private present() {
    const { markers, pipeline } = this.revisions.value;
    return { revision: markers, pipeline, scalar: this.scalar.value };
  }

  /** Whether the frames of the last look are there, so that the next one can be asked for. */
  get caughtUp(): boolean {
    return !this.waitsForLook();
  }

  /** Shows the target as if a point was there; null ends the drag. */
  dragTo(pair: number, side: Side, point: Point | null): void {
    if (point === null) {
      this.nextDrag = null;
      this.drag += 1;
      this.dragAnswered = this.drag;
      this.socket.send({ type: 'drag', drag: this.drag, pair, side, point });
      return;
    }
    this.nextDrag = { pair, side, point };
    this.sendDrag();
  }

  /**
   * Ends a drag whose point is `saved`. Of what the drag has sent, the last may reach the server after the edit, and would then be a drag
   * without an end.
   */
  async endDrag(pair: number, side: Side, saved: Promise<void>): Promise<void> {
    this.nextDrag = null;
    const { drag } = this;
    await saved;
    if (drag === this.drag && this.nextDrag === null) this.dragTo(pair, side, null);
  }

  receive(frame: Container<FrameHeader>): void {
    const { header } = frame;
    if (header.project !== this.project) return;
    const shown: Shown = {
      header,
      positions: floats(frame.arrays, 'positions'),
      values: frame.arrays.scalars ? floats(frame.arrays, 'scalars') : null,
      scalar: header.scalar,
    };
    if (header.channel === 'source') {
      if (header.look >= (this.source.peek()?.header.look ?? 0)) this.source.value = shown;
    } else if (header.channel === 'truth') {
      if (header.look >= (this.truth.peek()?.header.look ?? 0)) this.truth.value = shown;
      if (this.states.peek().truth) this.states.value = { ...this.states.peek(), truth: undefined };
    } else if (replaces(this.stamp, header)) {
      this.stamp = header;
      this.target.value = shown;
    }
    this.count(header);
  }

  setState(state: LiveState): void {
    this.states.value = { ...this.states.peek(), [state.channel]: state };
    if (state.channel === 'truth') {
      this.truth.value = null;
      return;
    }
    if (state.state === 'unavailable' || state.state === 'failed') this.answered = this.look;
  }

  /** After a connection was lost: nothing that was asked for will come. */
  reconnect(): void {
    this.answered = this.look;
    this.dragAnswered = this.drag;
    // A server that was started anew counts revisions anew.
    this.stamp = null;
    this.ask();
  }

  private count(header: FrameHeader): void {
    if (header.channel === 'preview' || header.channel === 'result') {
      this.answered = Math.max(this.answered, header.look);
      if (header.drag !== null && header.drag >= this.drag) {
        this.dragAnswered = header.drag;
        this.latency.value = performance.now() - this.dragSent;
      }
    }
    if (this.lookDue) this.ask();
    this.sendDrag();
  }

  private sendDrag(): void {
    if (!this.nextDrag) return;
    if (this.dragAnswered < this.drag && performance.now() - this.dragSent < PATIENCE_MILLISECONDS) {
      this.later();
      return;
    }
    this.drag += 1;
    this.dragSent = performance.now();
    this.socket.send({ type: 'drag', drag: this.drag, ...this.nextDrag });
    this.nextDrag = null;
  }

  private waitsForLook(): boolean {
    return this.answered < this.look && performance.now() - this.lookSent < PATIENCE_MILLISECONDS;
  }

  private later(): void {
    if (this.timer) return;
    this.timer = window.setTimeout(() => {
      this.timer = 0;
      if (this.lookDue) this.ask();
      this.sendDrag();
    }, PATIENCE_MILLISECONDS);
  }
}
