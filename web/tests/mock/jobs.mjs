/** A job that goes on by itself; `tell` hears of it. */
export function startJob(project, kind, tell) {
  const job = {
    id: project.jobs.length + 1,
    kind,
    project: project.opened,
    state: 'running',
    stage: 'correspondence',
    share: 0,
    poses: null,
    seconds: 0,
    seconds_left: null,
    error: null,
    warnings: [],
    result: null,
  };
  project.jobs.unshift(job);
  const stages = ['correspondence', 'transfer', 'metrics', 'report'];
  const timer = setInterval(() => {
    if (job.state !== 'running') return clearInterval(timer);
    job.seconds += 0.1;
    const t = job.seconds / 1.6;
    Object.assign(job, {
      stage: stages[Math.min(3, Math.floor(t * 4))],
      share: (t * 4) % 1,
      poses: { done: Math.min(24, Math.floor(t * 24)), count: 24 },
      seconds_left: Math.max(0, 1.6 - job.seconds),
    });
    if (t >= 1) {
      job.state = 'done';
      if (kind === 'run')
        job.result = {
          status: 'done',
          verdict: 'doubtful',
          written: [
            { name: 'camel.glb', path: 'out/camel.glb', bytes: 1482332, url: '/api/output/0' },
            { name: 'report.html', path: 'out/report.html', bytes: 223111, url: '/api/output/1' },
          ],
          report: {},
          summary: {
            total: 'look at 2 things',
            things: 2,
            faults: [{ metric: 'edge_stretch', sentence: 'edges are longer or shorter than they should be' }],
            next_steps: ['Look at pose `Walk 6`, the worst by edge stretch: its colours show where.'],
          },
          of: {
            project: project.number,
            markers: project.markers.revision,
            pipeline: project.pipelineRevision,
          },
          worst: project.worst(),
        };
    }
    tell(job);
  }, 100);
  return job;
}
