import { api, describeError, RequestError } from '../protocol/client.ts';
import type { Pipeline, Step } from '../protocol/types.ts';
import { notify, settle } from '../ui/notices.ts';
import { computed, signal } from '../ui/signal.ts';

/** Of notices. */
const TOPIC = 'pipeline';

/** Milliseconds until the page asks for the end of a check. */
const PATIENCE = 2000;

/** The pipeline in the page. Changes are sent one after another, each on the revision that the one before made. */
export class PipelineStore {
  readonly pipeline = signal<Pipeline | null>(null);
  readonly saving = signal(false);
  /** What another page or program wrote while this page had a change of its own. */
  readonly conflict = signal<Pipeline | null>(null);
  /** What is wrong in the text, as far as is known. */
  readonly mistakes = computed(() => (this.pipeline.value?.diagnostics ?? []).filter((one) => one.level === 'error'));
  private chain: Promise<unknown> = Promise.resolve();
  private asking: ReturnType<typeof setTimeout> | undefined;

  /** The pipeline of another project, or of a server that was started anew: its revisions are not those from before. */
  open(pipeline: Pipeline): void {
    this.conflict.value = null;
    this.pipeline.value = complete(pipeline);
    this.askLater();
  }

  receive(pipeline: Pipeline): void {
    const present = this.pipeline.peek();
    if (present && pipeline.revision < present.revision) return;
    // The answer to a change may come after the event that says what its check found.
    if (present?.revision === pipeline.revision && pipeline.checking && !present.checking) return;
    this.pipeline.value = complete(pipeline);
    this.askLater();
  }

  /** Asks what a check has found if no event says so: one that came while the project was loading is lost. */
  private askLater(): void {
    if (!this.pipeline.peek()?.checking) return;
    clearTimeout(this.asking);
    this.asking = setTimeout(() => {
      // Without an answer the connection is lost, and all is fetched anew when it is back.
      api.pipeline().then(
        (pipeline) => this.receive(pipeline),
        () => {},
      );
    }, PATIENCE);
  }

  /** Sets a value; whether it was done. */
  set(path: Step[], value: unknown): Promise<boolean> {
    return this.change((base) => api.setValue(base, path, value));
  }

  unset(path: Step[]): Promise<boolean> {
    return this.change((base) => api.unsetValue(base, path));
  }

  /** Takes back the last change of the pipeline, or does one again; whether it was done. */
  step(redo: boolean): Promise<boolean> {
    return this.change((base) => (redo ? api.redoPipeline(base) : api.undoPipeline(base)));
  }

  /** Resolves when the server has every change. */
  settled(): Promise<unknown> {
    return this.chain;
  }

  setText(base: number, text: string): Promise<boolean> {
    return this.change(() => api.putPipeline(base, text));
  }

  private change(send: (base: number) => Promise<Pipeline>): Promise<boolean> {
    this.saving.value = true;
    const step = this.chain.then(async () => {
      try {
        this.receive(await send(this.pipeline.peek()?.revision ?? 0));
        this.conflict.value = null;
        settle(TOPIC);
        return true;
      } catch (error) {
        this.failed(error);
        return false;
      }
    });
    this.chain = step;
    return step.finally(() => {
      if (this.chain === step) this.saving.value = false;
    });
  }

  private failed(error: unknown): void {
    if (error instanceof RequestError && error.status === 409 && isConflict(error.body)) {
      this.conflict.value = error.body.conflict;
      this.receive(error.body.conflict);
      notify(
        'The pipeline was changed elsewhere. Your last change was not saved.',
        'Look at the present text and change it again.',
        'error',
        TOPIC,
      );
      return;
    }
    const { message, hint } = describeError(error);
    notify(message, hint, 'error', TOPIC);
  }
}

/** While the first check of a pipeline is under way, the server knows no choices and outputs yet. */
function complete(pipeline: Pipeline): Pipeline {
  const { choices, diagnostics, outputs } = pipeline as Partial<Pipeline>;
  return { ...pipeline, choices: choices ?? [], diagnostics: diagnostics ?? [], outputs: outputs ?? [] };
}

function isConflict(body: unknown): body is { conflict: Pipeline } {
  return body !== null && typeof body === 'object' && 'conflict' in body;
}
