// A server that speaks docs/studio-protocol.md about made meshes, so that the page can be worked on and tested without the program.
import { readFile } from 'node:fs/promises';
import { createServer } from 'node:http';
import { extname, join, normalize } from 'node:path';
import { WebSocketServer } from 'ws';
import YAML from 'yaml';
import { writeContainer } from './container.mjs';
import { folder } from './folder.mjs';
import { startJob } from './jobs.mjs';
import { Project } from './project.mjs';
import { schema } from './schema.mjs';

const TYPES = {
  '.html': 'text/html',
  '.js': 'text/javascript',
  '.css': 'text/css',
  '.svg': 'image/svg+xml',
  '.json': 'application/json',
};
/** The ends of the colour scales, and limits. */
const LIMITS = {
  point_error: [0, 2, 1.5],
  edge_stretch: [0, 20, 15],
  component_gaps: [0, 2, 1],
  pair_confidence: [0, 100, null],
};
const POLICY =
  "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' blob: data:; font-src 'self'; connect-src 'self'; worker-src 'self' blob:; base-uri 'none'; form-action 'none'; frame-ancestors 'none'";

export class MockServer {
  constructor({ dist, resolution = 60, open = true, shapes = false, delay = 0, ahead = 200 }) {
    Object.assign(this, {
      dist,
      resolution,
      shapes,
      delay,
      ahead,
      projects: 0,
      project: null,
      sockets: new Set(),
      jobs: [],
    });
    if (open) this.open();
    this.server = createServer((request, response) => this.answer(request, response));
    this.live = new WebSocketServer({ server: this.server, path: '/api/live' });
    this.live.on('connection', (socket) => this.connect(socket));
  }

  listen(port = 0) {
    return new Promise((resolve) =>
      this.server.listen(port, '127.0.0.1', () => resolve(`http://127.0.0.1:${this.server.address().port}`)),
    );
  }

  close() {
    for (const socket of this.sockets) socket.terminate();
    this.server.closeAllConnections();
    return new Promise((resolve) => this.server.close(resolve));
  }

  /** Opens two meshes. Their pipeline is checked a moment later, as in the program; jobs of all projects are remembered. */
  open(files = {}) {
    this.projects += 1;
    const project = new Project(this.projects, this.resolution, this.shapes, files);
    project.jobs = this.jobs;
    this.project = project;
    setTimeout(() => {
      project.checked = true;
      if (this.project === project) this.broadcast({ type: 'pipeline', pipeline: project.pipeline(), cause: 'check' });
    }, 100).unref();
  }

  async answer(request, response) {
    const url = new URL(request.url, 'http://mock');
    const chunks = [];
    for await (const chunk of request) chunks.push(chunk);
    const raw = Buffer.concat(chunks);
    const json = request.headers['content-type'] === 'application/json' ? JSON.parse(raw.toString()) : null;
    const send = (status, body) => {
      response.writeHead(status, { 'Content-Type': 'application/json' });
      response.end(JSON.stringify(body));
    };
    const fail = (status, message, hint = null) =>
      send(status, { error: { code: status === 404 ? 'not_found' : 'unprocessable', message, hint, diagnostics: [] } });
    const route = `${request.method} ${url.pathname}`;
    if (!url.pathname.startsWith('/api/')) return this.file(url.pathname, response);
    const { project } = this;
    if (route === 'GET /api/session')
      return send(
        200,
        project
          ? project.session()
          : {
              project: null,
              version: '0.1.0',
              allow_commands: false,
              name: null,
              source: null,
              target: null,
              poses: null,
              scalars: [],
              has_truth: false,
              live: { preview: false, reason: null },
            },
      );
    if (route === 'GET /api/files') return send(200, folder(url.searchParams.get('path')));
    if (route === 'POST /api/upload')
      return send(200, { path: `/uploads/${url.searchParams.get('name')}`, bytes: raw.length });
    if (route === 'GET /api/about')
      return send(200, {
        version: '0.1.0',
        licences: JSON.parse(await readFile(join(this.dist, 'licences.json'), 'utf8')),
      });
    if (route === 'GET /api/schema') return send(200, schema);
    if (route === 'POST /api/open') {
      if (Object.values(json).some((path) => path.includes('broken')))
        return fail(422, 'broken.obj, line 12: the face names vertex 99, but there are 8', 'export the mesh again');
      this.open(json);
      const session = this.project.session();
      this.broadcast({ type: 'session', session });
      return send(200, session);
    }
    if (!project) return fail(404, 'nothing is open');
    const mesh = /^GET \/api\/mesh\/(source|target)$/.exec(route);
    if (mesh) {
      const { positions, triangles, components, welded, edges } = project.meshes[mesh[1]];
      response.writeHead(200, { 'Content-Type': 'application/octet-stream' });
      return response.end(
        writeContainer({ project: project.number, side: mesh[1] }, { positions, triangles, components, welded, edges }),
      );
    }
    const { markers } = project;
    if (route === 'GET /api/markers') return send(200, markers.view());
    if (route.startsWith('POST /api/markers')) {
      if (route.endsWith('/propose')) return send(200, this.job('propose'));
      const result = route.endsWith('/undo')
        ? markers.step(markers.past, markers.future, json.base)
        : route.endsWith('/redo')
          ? markers.step(markers.future, markers.past, json.base)
          : markers.edit(json);
      this.broadcast({ type: 'markers', markers: markers.view(), cause: 'edit' });
      this.refresh();
      return send(result.conflicts.length ? 409 : 200, result);
    }
    if (route === 'GET /api/markers/next') {
      const pair = markers
        .view()
        .pairs.filter((p) => p.status === 'proposed')
        .sort((a, b) => a.confidence - b.confidence)[0];
      return send(
        200,
        pair
          ? {
              kind: 'doubtful',
              pair: pair.id,
              source: pair.source,
              target: pair.target,
              reason: 'This pair is the least sure.',
            }
          : { kind: 'none', pair: null, source: null, target: null, reason: 'All pairs are confirmed.' },
      );
    }
    if (route === 'GET /api/pipeline') return send(200, project.pipeline());
    if (route === 'POST /api/yaml') {
      try {
        return send(200, { value: YAML.parse(json.text), problem: null });
      } catch {
        return send(200, { value: null, problem: 'this is no YAML' });
      }
    }
    if (/^(PUT|POST) \/api\/pipeline/.test(route)) {
      if (json.base !== project.pipelineRevision) return send(409, { conflict: project.pipeline() });
      const before = project.number;
      if (request.method === 'PUT') project.take(json.text, 'edit the text of the pipeline');
      else if (route.endsWith('/undo')) project.step(project.past, project.future);
      else if (route.endsWith('/redo')) project.step(project.future, project.past);
      else project.change(json.path, route.endsWith('unset') ? undefined : json.value);
      if (project.number !== before) this.broadcast({ type: 'session', session: project.session() });
      this.broadcast({ type: 'pipeline', pipeline: project.pipeline(), cause: 'edit' });
      for (const socket of this.sockets) this.prepare(socket);
      return send(200, project.pipeline());
    }
    if (route === 'POST /api/run') return send(200, this.job('run'));
    if (route === 'GET /api/jobs') return send(200, project.jobs);
    if (route.startsWith('DELETE /api/jobs/')) {
      const job = project.jobs.find((other) => other.id === Number(url.pathname.split('/').pop()));
      job.state = 'cancelled';
      this.broadcast({ type: 'job', job });
      return send(200, job);
    }
    if (url.pathname.startsWith('/api/masks')) return this.mask(request.method, url, raw, json, send, response);
    return fail(404, 'no such route');
  }

  mask(method, url, raw, json, send, response) {
    const [side, name, components] = url.pathname.split('/').slice(3);
    const { masks } = this.project;
    const key = `${side}/${name}`;
    const list = () => ({ masks: [...masks.values()].map(({ data, ...mask }) => mask) });
    if (!side) return send(200, list());
    if (method === 'PUT' && masks.has(key) && url.searchParams.get('replace') !== 'true') {
      const message = `${name} is there already`;
      return send(409, { error: { code: 'conflict', message, hint: null, diagnostics: [] } });
    }
    if (method === 'PUT') {
      const mask = {
        name: decodeURIComponent(name),
        side,
        file: `${name}.${side}.mask.json`,
        kind: components ? 'components' : 'weights',
      };
      masks.set(key, { ...mask, data: json ?? raw });
      return send(200, mask);
    }
    if (method === 'DELETE') {
      masks.delete(key);
      return send(200, list());
    }
    response.writeHead(200);
    return response.end(masks.get(key).data);
  }

  async file(path, response) {
    const name = path === '/' ? 'index.html' : normalize(path).replace(/^[/.]+/, '');
    const body = await readFile(join(this.dist, name)).catch(() => null);
    response.writeHead(body ? 200 : 404, {
      'Content-Type': TYPES[extname(name)] ?? 'application/octet-stream',
      'Content-Security-Policy': POLICY,
    });
    response.end(body);
  }

  job(kind) {
    return startJob(this.project, kind, (job) => this.broadcast({ type: 'job', job }));
  }

  connect(socket) {
    this.sockets.add(socket);
    socket.on('close', () => {
      clearInterval(socket.preparing);
      this.sockets.delete(socket);
    });
    socket.on('message', (data) => this.receive(socket, JSON.parse(data.toString())));
    const { project } = this;
    socket.send(
      JSON.stringify({
        type: 'hello',
        project: project?.number ?? null,
        markers: project?.markers.revision ?? 0,
        pipeline: project?.pipelineRevision ?? 0,
      }),
    );
  }

  receive(socket, message) {
    if (message.type === 'look') {
      const scalar = socket.look?.scalar;
      socket.look = message;
      if (message.scalar !== scalar || !socket.preparing) this.prepare(socket);
    }
    if (message.type === 'drag') socket.drag = message.point ? message : null;
    if (!this.project || !socket.look || socket.due) return;
    socket.due = true;
    const channels = message.type === 'drag' ? ['preview'] : socket.look.channels;
    setTimeout(() => {
      socket.due = false;
      this.frames(socket, channels);
      socket.send(
        JSON.stringify({
          type: 'worst',
          channel: 'result',
          revision: this.project.markers.revision,
          list: this.project.worst(),
        }),
      );
    }, this.delay);
  }

  /** Results of all frames are there after `ahead` milliseconds. */
  prepare(socket) {
    if (!this.project || this.project.shapes || !socket.look) return;
    clearInterval(socket.preparing);
    const count = this.project.session().poses.list.length;
    let done = 0;
    const tell = () => {
      const { markers, pipelineRevision: pipeline } = this.project;
      const { scalar } = socket.look;
      const message = { revision: markers.revision, pipeline, done, count, step: 1, scalar, error: null };
      socket.send(JSON.stringify({ type: 'ahead', ...message }));
      if (done === count) clearInterval(socket.preparing);
      done = Math.min(done + Math.ceil(count / 4), count);
    };
    socket.preparing = setInterval(tell, this.ahead / 4);
    tell();
  }

  refresh() {
    for (const socket of this.sockets) {
      this.prepare(socket);
      socket.drag = null;
      if (socket.look) this.frames(socket, ['preview', 'result']);
    }
  }

  frames(socket, channels) {
    const { project } = this;
    const { look, pose, scalar } = socket.look;
    for (const channel of channels) {
      if (!socket.look.channels.includes(channel)) continue;
      const start = performance.now();
      const positions = project.positions(channel, pose, socket.drag);
      const arrays = { positions };
      const known = project.session().scalars.find((other) => other.name === scalar);
      const coloured = known && channel !== 'source';
      const limits = LIMITS[scalar];
      if (coloured) arrays.scalars = project.scalars(scalar, pose, positions);
      const header = {
        project: project.number,
        channel,
        look,
        drag: channel === 'preview' ? (socket.drag?.drag ?? null) : null,
        pose,
        revision: project.markers.revision,
        pipeline: project.pipelineRevision,
        scalar: coloured
          ? {
              name: known.name,
              title: known.title,
              unit: known.unit,
              low: limits[0],
              high: limits[1],
              limit: limits[2],
            }
          : null,
        milliseconds: performance.now() - start,
      };
      socket.send(writeContainer(header, arrays));
    }
  }

  broadcast(message) {
    for (const socket of this.sockets) socket.send(JSON.stringify(message));
  }
}
