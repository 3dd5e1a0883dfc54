import { Live } from '../live/live.ts';
import { MarkerStore } from '../markers/store.ts';
import { Painting } from '../paint/painting.ts';
import { api, describeError, type Failure, RequestError, sentence } from '../protocol/client.ts';
import { Socket } from '../protocol/socket.ts';
import type { FromServer, Job, OpenRequest, Point, Session, Side } from '../protocol/types.ts';
import { PipelineStore } from '../stages/store.ts';
import { FileChoice } from '../start/choice.ts';
import { rememberRecent } from '../start/recent.ts';
import { clearNotices, notify, settle, settleErrors } from '../ui/notices.ts';
import { computed, effect, signal } from '../ui/signal.ts';
import { follows, tellProposals } from './jobs.ts';
import { loadMesh, type Meshes, sameMeshes, warnOfFiles } from './meshes.ts';
import { Runs } from './runs.ts';
import { Undo } from './undo.ts';

export type Phase =
  | { name: 'loading'; text: string }
  | { name: 'start' }
  | ({ name: 'failed' } & Failure)
  | { name: 'ready' };

export type Panel = 'points' | 'result' | 'stages' | 'paint';

export interface DraggedPoint {
  pair: number;
  side: Side;
  point: Point;
}

/** All that the page knows: the project, what is selected, and how things are shown. */
export class Studio {
  readonly socket = new Socket();
  readonly live = new Live(this.socket);
  readonly markers = new MarkerStore();
  readonly pipeline = new PipelineStore();
  readonly painting = new Painting();
  readonly history = new Undo(this);
  readonly files = new FileChoice();
  readonly phase = signal<Phase>({ name: 'loading', text: 'Connecting …' });
  readonly session = signal<Session | null>(null);
  readonly meshes = signal<Meshes | null>(null);
  readonly jobs = signal<Job[]>([]);
  /** Which run belongs to which project. */
  readonly runs = new Runs(this);
  /** Whether the server is there but does not know this page. */
  readonly refused = signal(false);
  readonly panel = signal<Panel>('points');
  readonly selected = signal<number | null>(null);
  /** The selected pair if it was begun by a click: once it is complete, the next click begins another. */
  readonly fresh = signal<{ pair: number; complete: boolean } | null>(null);
  readonly hovered = signal<number | null>(null);
  readonly dragged = signal<DraggedPoint | null>(null);
  readonly hidden = { source: signal<ReadonlySet<number>>(new Set()), target: signal<ReadonlySet<number>>(new Set()) };
  private loading = 0;

  constructor() {
    this.socket.onMessage = (message) => this.receive(message);
    this.socket.onFrame = (frame) => {
      // What was wrong with what the page asked for is so no more.
      settle('live');
      this.live.receive(frame);
    };
    this.socket.onOpen = () => void this.connected();
    this.socket.onLost = () => void this.lookForServer();
    effect(() => {
      const pipeline = this.pipeline.pipeline.value?.revision ?? 0;
      this.live.revisions.value = { markers: this.markers.document.value.revision, pipeline };
    });
    // What failed because of points or settings may do with others.
    const state = computed(() => {
      const { markers, pipeline } = this.live.revisions.value;
      return `${markers} ${pipeline} ${this.pipeline.mistakes.value.length}`;
    });
    effect(() => {
      void state.value;
      settleErrors(['run', 'propose', 'next']);
    });
    this.markers.onNotice = ({ text, hint }) => notify(text, hint);
    this.markers.onRenumbered = (ids) => {
      const id = this.selected.peek();
      if (id !== null && ids.has(id)) this.selected.value = ids.get(id) ?? null;
      const fresh = this.fresh.peek();
      if (fresh) this.fresh.value = { ...fresh, pair: ids.get(fresh.pair) ?? fresh.pair };
    };
    effect(() => {
      if (this.fresh.value && this.fresh.value.pair !== this.selected.value) this.fresh.value = null;
    });
  }

  start(): void {
    this.socket.connect();
    // Meshes need not wait for the WebSocket.
    void this.load();
  }

  async open(what: OpenRequest): Promise<void> {
    this.phase.value = { name: 'loading', text: 'Reading meshes …' };
    try {
      await this.show(await api.open(what));
      rememberRecent(what);
      this.files.reset();
    } catch (error) {
      const failure = describeError(error);
      const { message, hint, diagnostics } = failure;
      this.files.dropNamedIn([message, hint, ...diagnostics.flatMap((one) => [one.file, one.message])].join(' '));
      this.phase.value = { name: 'failed', ...failure };
    }
  }

  /** Back to the choice of files; what is open stays open on the server. */
  chooseFiles(): void {
    this.phase.value = { name: 'start' };
  }

  /** Whether files are being chosen while a project is open, to which Escape leads back. */
  canLeaveChoice(): boolean {
    return this.phase.peek().name === 'start' && this.session.peek()?.project != null && this.meshes.peek() !== null;
  }

  async load(): Promise<void> {
    try {
      await this.show(await api.session());
    } catch (error) {
      this.phase.value = { name: 'failed', ...describeError(error) };
    }
  }

  async run(): Promise<void> {
    const [mistake] = this.pipeline.mistakes.value;
    if (mistake && !this.pipeline.pipeline.peek()?.checking) {
      this.panel.value = 'stages';
      notify(sentence(mistake.message), 'Mend it under Stages, and run again.', 'error', 'run');
      return;
    }
    try {
      await this.markers.settled();
      settle('run');
      this.setJob(await api.run());
      this.panel.value = 'result';
    } catch (error) {
      const { message, hint } = describeError(error);
      notify(message, hint, 'error', 'run');
    }
  }

  async cancel(job: Job): Promise<void> {
    try {
      this.setJob(await api.cancel(job.id));
    } catch (error) {
      notify(describeError(error).message, null, 'error', job.kind);
    }
  }

  async propose(others?: number): Promise<void> {
    try {
      await this.markers.settled();
      // Before the request: the job may be done before its answer is there.
      settle('propose');
      this.setJob(await api.propose(others));
    } catch (error) {
      const { message, hint } = describeError(error);
      notify(message, hint, 'error', 'propose');
    }
  }

  private async show(session: Session): Promise<void> {
    const before = this.session.peek();
    this.session.value = session;
    if (session.project === null) {
      this.phase.value = { name: 'start' };
      return;
    }
    if (before?.project === session.project && this.meshes.peek()) {
      this.phase.value = { name: 'ready' };
      return;
    }
    this.loading += 1;
    const turn = this.loading;
    this.phase.value = { name: 'loading', text: 'Loading meshes …' };
    const [source, target, markers, pipeline, jobs] = await Promise.all([
      loadMesh('source'),
      loadMesh('target'),
      api.markers(),
      api.pipeline(),
      api.jobs(),
    ]);
    // Another project may have been opened meanwhile.
    if (turn !== this.loading) return;
    // Another clip of the same meshes leaves what a person chose.
    const isSame = before !== null && before.name === session.name && sameMeshes(before, session);
    if (!isSame) {
      clearNotices();
      this.selected.value = null;
      if (before !== null) this.panel.value = 'points';
      this.hidden.source.value = new Set();
      this.hidden.target.value = new Set();
    }
    settle('live');
    this.markers.open(session.project, markers.file ?? session.name ?? '', markers);
    this.pipeline.open(pipeline);
    const left = this.painting.open(session);
    this.history.rebase();
    this.jobs.value = jobs;
    this.meshes.value = { source, target };
    this.live.open(session.project);
    this.phase.value = { name: 'ready' };
    if (!isSame) warnOfFiles(session);
    // The proposals of a new project may be there before its meshes are.
    const isNew = !isSame && !markers.exists && markers.pairs.length > 0;
    if (isNew && jobs.every((job) => job.state !== 'running')) tellProposals(this.markers.pairs.peek());
    if (left.length > 0)
      notify(
        `What was painted on ${left.join(' and ')} is not saved.`,
        'It comes back when its project is opened again in this page.',
      );
    document.title = `${session.name ?? 'mimesh'} – mimesh studio`;
  }

  /** A connection was made, perhaps after one was lost: what happened meanwhile is fetched. */
  private async connected(): Promise<void> {
    if (this.meshes.peek() === null) return;
    try {
      // What a server that was started anew has open has another number, even if it is the same pipeline.
      await this.show(await api.session());
      this.markers.reopen(await api.markers());
      this.pipeline.open(await api.pipeline());
      this.history.rebase();
      this.jobs.value = await api.jobs();
      this.live.reconnect();
      settle('connection');
    } catch (error) {
      notify(describeError(error).message, null, 'error', 'connection');
    }
  }

  /** A server that was started anew has another token, which is no fault of the connection. */
  private async lookForServer(): Promise<void> {
    try {
      await api.session();
      this.refused.value = false;
    } catch (error) {
      this.refused.value = error instanceof RequestError && (error.status === 401 || error.status === 403);
    }
  }

  private receive(message: FromServer): void {
    switch (message.type) {
      case 'hello':
        break;
      case 'session':
        // Another page opened files; the one that did so has them already.
        if (message.session.project !== this.session.peek()?.project) void this.show(message.session).catch(() => {});
        else this.session.value = message.session;
        break;
      case 'markers':
        this.markers.receive(message.markers);
        if (message.cause === 'disk') notify('The pairs were changed by another program, and were read again.');
        break;
      case 'pipeline':
        this.pipeline.receive(message.pipeline);
        if (message.cause === 'disk') notify('The pipeline was changed by another program, and was read again.');
        break;
      case 'job':
        this.setJob(message.job);
        break;
      case 'live':
        this.live.setState(message);
        break;
      case 'worst':
        this.live.worst.value = message.list;
        break;
      case 'ahead':
        this.live.ahead.value = message;
        break;
      case 'error':
        // What was asked of the meshes from before is of no interest any more.
        if (this.phase.peek().name === 'ready')
          notify(sentence(message.error.message), message.error.hint, 'error', 'live');
    }
  }

  /** A run writes the files of the project that were not there yet, which the server does not announce. */
  private async readFiles(): Promise<void> {
    const project = this.session.peek()?.project;
    try {
      const [pipeline, markers] = await Promise.all([api.pipeline(), api.markers()]);
      if (project !== this.session.peek()?.project) return;
      this.pipeline.receive(pipeline);
      this.markers.receive(markers);
    } catch {
      // The next change brings both.
    }
  }

  private setJob(job: Job): void {
    this.runs.note(job);
    const before = this.jobs.peek().find((other) => other.id === job.id);
    if (!follows(job, before)) return;
    const others = this.jobs.peek().filter((other) => other.id !== job.id);
    this.jobs.value = [job, ...others].sort((a, b) => b.id - a.id);
    if (before?.state === job.state) return;
    if (job.state === 'failed') notify(sentence(job.error?.message ?? 'it failed'), job.error?.hint, 'error', job.kind);
    if (job.state !== 'done') return;
    if (job.kind === 'run') void this.readFiles();
    if (job.kind === 'run')
      notify(`The run is done. ${sentence(job.result?.summary.total ?? '')}`, null, 'info', 'run');
    else void this.markers.settled().then(() => tellProposals(this.markers.pairs.peek()));
  }
}
