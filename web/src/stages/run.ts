import type { Studio } from '../app/studio.ts';
import { sentence } from '../protocol/client.ts';
import type { Job, RunResult } from '../protocol/types.ts';
import { button, progressBar } from '../ui/controls.ts';
import { fill, h } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { effect } from '../ui/signal.ts';
import { verdict } from '../ui/verdict.ts';

/** The job that is under way, if any. */
export function runningJob(studio: Studio): Job | null {
  return studio.jobs.value.find((job) => job.state === 'running') ?? null;
}

/** The button in the bar: it runs, and shows how far a run is. */
export function runControl(studio: Studio): HTMLElement {
  const run = button({ label: 'Run', kind: 'primary', icon: 'play', run: () => void studio.run() });
  run.title = 'Runs the whole pipeline and writes its files';
  const text = h('span', { class: 'job-text' });
  const job = h(
    'div',
    { class: 'job' },
    h(
      'div',
      { class: 'job-lines' },
      text,
      progressBar('Progress of the run', () => shareOf(runningJob(studio))),
    ),
    button({
      label: 'Cancel',
      run: () => {
        const running = runningJob(studio);
        if (running) void studio.cancel(running);
      },
    }),
  );
  effect(() => {
    const running = runningJob(studio);
    run.hidden = running !== null;
    run.disabled = studio.session.value?.project === null;
    job.hidden = running === null;
    if (running) text.textContent = describe(running);
  });
  return h('div', { class: 'run-control' }, run, job);
}

function shareOf(job: Job | null): number | null {
  if (!job) return null;
  if (job.poses && job.poses.count > 0 && job.stage === 'transfer') return job.poses.done / job.poses.count;
  return job.share;
}

function describe(job: Job): string {
  const what = job.stage ?? (job.kind === 'run' ? 'running' : 'finding points');
  const poses = job.poses && job.poses.done > 0 ? ` · ${job.poses.done} of ${job.poses.count}` : '';
  const left = job.seconds_left === null ? '' : ` · ${Math.ceil(job.seconds_left)} s left`;
  return `${what}${poses}${left}`;
}

/** What the last run wrote. */
export function runReport(studio: Studio): HTMLElement {
  const element = h('section', { class: 'block', 'aria-label': 'Last run' });
  effect(() => {
    const job = studio.jobs.value.find((other) => other.kind === 'run');
    element.hidden = !job || job.state === 'running';
    if (job) fill(element, h('h3', {}, 'Last run'), ...reportOf(job));
  });
  return element;
}

function reportOf(job: Job): Node[] {
  if (job.state === 'cancelled') return [h('p', {}, 'Cancelled. Nothing was written.')];
  if (job.state === 'failed') {
    return [
      h('p', { class: 'problem' }, sentence(job.error?.message ?? 'it failed')),
      ...(job.error?.hint ? [h('p', { class: 'hint' }, sentence(job.error.hint))] : []),
      ...(job.error?.diagnostics ?? []).map((entry) => h('p', { class: 'problem' }, entry.message)),
    ];
  }
  return job.result ? [...verdictOf(job.result, job.seconds), ...filesOf(job.result)] : [];
}

function verdictOf(result: RunResult, seconds: number): Node[] {
  const level = result.verdict;
  return [h('p', {}, level ? verdict(level) : null, ` ${OUTCOMES[result.status]} in ${seconds.toFixed(1)} s`)];
}

const OUTCOMES: Record<RunResult['status'], string> = {
  done: 'Done',
  gate: 'Done, but a limit was exceeded,',
  partly: 'Partly done',
};

function filesOf(result: RunResult): HTMLElement[] {
  const folders = new Set(result.written.map((file) => folderOf(file.path)));
  const [folder] = folders;
  const together = folders.size === 1;
  const files = result.written.map((file) =>
    h(
      'li',
      {},
      h('a', { href: file.url, target: '_blank', rel: 'noopener', title: file.path }, icon('file'), file.name),
      h('span', { class: 'muted' }, together ? bytes(file.bytes) : `${file.path} · ${bytes(file.bytes)}`),
    ),
  );
  return [
    h('ul', { class: 'files' }, ...files),
    ...(together ? [h('p', { class: 'muted place' }, `In ${folder}`)] : []),
  ];
}

function folderOf(path: string): string {
  return path.replace(/[\\/][^\\/]*$/, '');
}

export function bytes(count: number): string {
  if (count < 1000) return `${count} B`;
  if (count < 1e6) return `${(count / 1e3).toFixed(0)} kB`;
  if (count < 1e9) return `${(count / 1e6).toFixed(1)} MB`;
  return `${(count / 1e9).toFixed(1)} GB`;
}
