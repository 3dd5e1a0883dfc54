import type { Studio } from '../app/studio.ts';
import { sentence } from '../protocol/client.ts';
import type { Job, RunResult, Worst } from '../protocol/types.ts';
import { button, progressBar } from '../ui/controls.ts';
import { fill, h } from '../ui/dom.ts';
import { icon } from '../ui/icons.ts';
import { inline, prose, splitCommands } from '../ui/prose.ts';
import { effect } from '../ui/signal.ts';
import { verdict } from '../ui/verdict.ts';
import { listed as listNames, readableIn } from '../ui/words.ts';

/** The job that is under way, if any. */
export function runningJob(studio: Studio): Job | null {
  return studio.jobs.value.find((job) => job.state === 'running') ?? null;
}

/** The button in the bar: it runs, and shows how far a run is. */
export function runControl(studio: Studio): HTMLElement {
  const run = button({ label: 'Run', kind: 'primary', icon: 'play', run: () => void studio.run() });
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
    run.title = whatRunDoes(studio);
    job.hidden = running === null;
    if (running) text.textContent = describe(running);
  });
  return h('div', { class: 'run-control' }, run, job);
}

/** What a run will do, for the tooltip of its button. */
export function whatRunDoes(studio: Studio): string {
  const [mistake] = studio.pipeline.mistakes.value;
  if (mistake) {
    const line = mistake.line === null ? '' : `Line ${mistake.line}: `;
    return `A run would stop at a mistake in the pipeline. ${line}${sentence(mistake.message)} Stages shows it.`;
  }
  const outputs = studio.pipeline.pipeline.value?.outputs ?? [];
  const writes = studio.runs.last()?.state === 'done' ? 'replaces' : 'writes';
  return `Runs the whole pipeline and ${writes} ${outputs.length > 0 ? listNames(outputs) : 'its files'}.`;
}

function shareOf(job: Job | null): number | null {
  if (!job) return null;
  if (job.poses && job.poses.count > 0 && job.stage === 'transfer') return job.poses.done / job.poses.count;
  return job.share;
}

function describe(job: Job): string {
  const what = job.stage ?? (job.kind === 'run' ? 'running' : 'finding pairs');
  const poses = job.poses && job.poses.done > 0 ? ` · ${job.poses.done} of ${job.poses.count}` : '';
  const left = job.seconds_left === null ? '' : ` · ${Math.ceil(job.seconds_left)} s left`;
  return `${what}${poses}${left}`;
}

/** What the last run found and wrote; `show` shows the place of a statistic. */
export function runReport(studio: Studio, show: (worst: Worst) => void): HTMLElement {
  const body = h('div', { class: 'run-body' });
  const old = h('p', { class: 'doubt outdated', role: 'status' });
  const element = h('section', { class: 'block', 'aria-label': 'Last run' }, h('h3', {}, 'Last run'), old, body);
  const last = () => studio.runs.last();
  effect(() => {
    const job = last();
    element.hidden = !job || job.state === 'running';
    if (job) fill(body, ...reportOf(job, show));
  });
  // What a run found is seen without a search for it.
  let seen: string | null = null;
  effect(() => {
    const job = last();
    const state = job && `${job.id} ${job.state}`;
    if (seen?.endsWith('running') && job && job.state !== 'running')
      requestAnimationFrame(() => element.scrollIntoView());
    seen = state;
  });
  effect(() => {
    const job = last();
    old.hidden = job === null || job.state === 'running' || !studio.runs.isOutdated(job);
    old.textContent = old.hidden ? '' : 'Out of date: pairs or settings have changed since this run. Run again.';
  });
  return element;
}

function reportOf(job: Job, show: (worst: Worst) => void): Node[] {
  if (job.state === 'cancelled') return [h('p', {}, 'Cancelled. Nothing was written.')];
  if (job.state === 'failed') {
    return [
      h('p', { class: 'problem' }, ...inline(sentence(job.error?.message ?? 'it failed'))),
      ...(job.error?.hint ? prose(splitCommands(sentence(job.error.hint)).page) : []),
      ...(job.error?.diagnostics ?? []).map((entry) => h('p', { class: 'problem' }, ...inline(entry.message))),
    ];
  }
  return job.result
    ? [...verdictOf(job.result, job.seconds), ...summaryOf(job.result, show), ...filesOf(job.result)]
    : [];
}

function verdictOf(result: RunResult, seconds: number): Node[] {
  const level = result.verdict;
  return [h('p', {}, level ? verdict(level) : null, ` ${OUTCOMES[result.status]} in ${seconds.toFixed(1)} s`)];
}

/** The sentences of the report: the whole in a few words, what is wrong, and what to do next. */
function summaryOf(result: RunResult, show: (worst: Worst) => void): Node[] {
  const { summary, worst, written } = result;
  const steps = summary.next_steps
    .map(splitCommands)
    .map(({ page, commands }) => ({ page: readableIn(page), commands }));
  const commands = steps.map((step) => step.commands).filter(Boolean);
  const report = written.find((file) => file.name.endsWith('.html'));
  const faults = summary.faults.map(({ metric, sentence: text }) => {
    const first = worst.find((one) => one.metric === metric);
    return h(
      'li',
      {},
      first?.words === text ? null : h('p', {}, ...inline(sentence(text))),
      first ? button({ label: readableIn(first.words), icon: 'eye', run: () => show(first) }) : null,
    );
  });
  return [
    h('p', { class: 'total' }, sentence(summary.total)),
    ...(faults.length > 0 ? [h('ul', { class: 'faults-of-run' }, ...faults)] : []),
    h('h4', {}, 'What to do next'),
    h('ol', { class: 'next-steps' }, ...listed(steps.map(({ page }) => page))),
    ...(commands.length > 0
      ? [
          h(
            'details',
            { class: 'on-command-line' },
            h('summary', {}, 'On the command line'),
            h('ul', {}, ...listed(commands)),
          ),
        ]
      : []),
    ...(report
      ? [h('p', {}, h('a', { href: report.url, target: '_blank', rel: 'noopener' }, 'Open the whole report'))]
      : []),
  ];
}

/** Items of a list, without those that say nothing. */
function listed(texts: string[]): HTMLElement[] {
  return texts.filter(Boolean).map((text) => h('li', {}, ...prose(text)));
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
