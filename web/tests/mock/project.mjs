// What the mock server holds: two animals, their walk, a document of markers, a pipeline and jobs.
import YAML from 'yaml';
import { animal, NAMED, nearestVertex, walk } from './animal.mjs';
import { MarkerDocument } from './markers.mjs';
import { nextOrder } from './order.mjs';

const FRAMES = 24;

const TEXT = `# A walk of a horse for a camel.
source: { rest: horse.glb }
target: { rest: camel.glb }
correspondence: { type: nonrigid_fit, steps: 4 }
transfer:
  type: biharmonic
  weights: { type: bounded_biharmonic }
output: [out/camel.glb, out/report.html]
`;

export class Project {
  constructor(number, resolution, shapes, { source = 'horse.glb', target = 'camel.glb' } = {}) {
    this.number = number;
    this.opened = number;
    this.shapes = shapes;
    this.files = { source: source.split('/').pop(), target: target.split('/').pop() };
    const kinds = { source: kindOf(source), target: kindOf(target) };
    this.meshes = {
      source: animal(kinds.source, resolution),
      target: animal(kinds.target, Math.round(resolution * 1.1)),
    };
    this.markers = new MarkerDocument(proposals(this.meshes, kinds));
    /** The program knows no choices before the first check has ended. */
    this.checked = false;
    this.pipelineRevision = 1;
    this.text = TEXT;
    this.past = [];
    this.future = [];
    // A file with shapes may have a clip too, whose frames become the poses once it is chosen.
    this.clip = shapes ? null : 'Walk';
    this.masks = new Map();
    this.jobs = [];
  }

  facts(side) {
    const mesh = this.meshes[side];
    const low = [0, 1, 2].map((i) => mesh.positions.reduce((m, x, k) => (k % 3 === i ? Math.min(m, x) : m), Infinity));
    const high = [0, 1, 2].map((i) =>
      mesh.positions.reduce((m, x, k) => (k % 3 === i ? Math.max(m, x) : m), -Infinity),
    );
    return {
      file: this.files[side],
      vertices: mesh.positions.length / 3,
      polygons: mesh.polygons,
      triangles: mesh.triangles.length / 3,
      components: mesh.facts,
      bounds: [low, high],
      origin: [0, 0, 0],
      diagonal: Math.hypot(...high.map((h, i) => h - low[i])),
      up: 'y',
      unit: 'm',
      warnings: [],
    };
  }

  /** Made once, since every frame asks for it. */
  session() {
    this.made ??= this.makeSession();
    return this.made;
  }

  makeSession() {
    const areShapes = this.clip === null;
    const names = areShapes
      ? ['jawOpen', 'smileLeft', 'smileRight', 'browUp', 'blink']
      : Array.from({ length: FRAMES }, (_, i) => `${this.clipAt(i)} ${i}`);
    return {
      project: this.number,
      opened: this.opened,
      version: '0.1.0',
      allow_commands: false,
      name: `${stem(this.files.target)}-from-${stem(this.files.source)}`,
      source: this.facts('source'),
      target: this.facts('target'),
      poses: {
        are: areShapes ? 'shapes' : 'frames',
        fps: areShapes ? null : 24,
        clips: this.shapes
          ? [{ name: 'Wave', seconds: 1, frames: FRAMES }]
          : [
              { name: 'Walk', seconds: 1, frames: FRAMES },
              { name: 'Run', seconds: 0.5, frames: 12 },
            ],
        list: names.map((name, i) => ({
          name,
          clip: areShapes ? null : this.clipAt(i),
          seconds: areShapes ? null : i / 24,
        })),
      },
      scalars: [
        { name: 'point_error', title: 'point error', unit: '%', needs_truth: true },
        { name: 'edge_stretch', title: 'edge stretch', unit: '%', needs_truth: false },
        { name: 'component_gaps', title: 'component gaps', unit: '%', needs_truth: false },
        { name: 'pair_confidence', title: 'pair confidence', unit: '%', needs_truth: false },
      ],
      has_truth: true,
      live: { preview: true, reason: null },
    };
  }

  /** Of all clips each has half of the frames. */
  clipAt(frame) {
    if (this.clip !== '*') return this.clip;
    return frame < FRAMES / 2 ? 'Walk' : 'Run';
  }

  pipeline() {
    let value = null;
    const diagnostics = [];
    const document = YAML.parseDocument(this.text);
    for (const error of document.errors) {
      const at = error.linePos?.[0];
      diagnostics.push({
        level: 'error',
        message: error.message.split('\n')[0],
        hint: null,
        file: 'camel-from-horse.yaml',
        line: at?.line ?? 1,
        column: at?.col ?? 1,
        length: 1,
        path: null,
      });
    }
    if (document.errors.length === 0) value = document.toJS();
    const steps = value?.correspondence?.steps;
    if (steps !== undefined && !(steps >= 1 && steps <= 20)) {
      const line = this.text.split('\n').findIndex((text) => text.includes('steps')) + 1;
      diagnostics.push({
        level: 'error',
        message: `steps is ${steps}, but must be from 1 to 20`,
        hint: 'leave it out for 4',
        file: 'camel-from-horse.yaml',
        line,
        column: this.text.split('\n')[line - 1].indexOf('steps') + 1,
        length: 5,
        path: ['correspondence', 'steps'],
      });
    }
    return {
      revision: this.pipelineRevision,
      file: 'camel-from-horse.yaml',
      exists: true,
      text: this.text,
      value,
      diagnostics,
      checking: !this.checked,
      choices: this.checked
        ? [{ slot: 'proximity', value: { type: 'spanning_tree' }, reason: 'the target has 3 parts' }]
        : null,
      outputs: ['out/camel.glb', 'out/report.html'],
      disk: 'saved',
      disk_error: null,
      undo: this.past.at(-1)?.title ?? null,
      undo_order: this.past.at(-1)?.order ?? null,
      redo: this.future.at(-1)?.title ?? null,
      redo_order: this.future.at(-1)?.order ?? null,
    };
  }

  /** Takes a text for the pipeline, as a step of undo. */
  take(text, title) {
    this.past.push({ text: this.text, title, order: nextOrder() });
    this.future = [];
    this.text = text;
    this.pipelineRevision += 1;
  }

  /** Undoes a step, or does one again. */
  step(from, to) {
    const step = from.pop();
    to.push({ ...step, text: this.text });
    this.text = step.text;
    this.pipelineRevision += 1;
  }

  change(path, value) {
    const document = YAML.parseDocument(this.text);
    if (value === undefined) document.deleteIn(path);
    else document.setIn(path, document.createNode(value));
    this.take(document.toString(), `set ${path.join('.')}`);
    // Another clip is other poses of the same meshes.
    const clip = path[1] === 'poses' ? (value?.clip ?? value ?? null) : undefined;
    if (clip !== undefined && (clip || this.shapes)) {
      this.clip = clip;
      this.number += 1000;
      this.made = null;
    }
  }

  /** The positions of a channel for a pose; `drag` pulls the surface about a point, so that a drag can be seen. */
  positions(channel, pose, drag) {
    const mesh = this.meshes[channel === 'source' ? 'source' : 'target'];
    let result = mesh.positions.slice();
    if (pose?.index !== undefined) result = walk(mesh, pose.index / FRAMES, 1);
    for (const [index, weight] of pose?.blend ?? []) {
      const posed = walk(mesh, index / 5, 1);
      for (let i = 0; i < result.length; i++) result[i] += weight * (posed[i] - mesh.positions[i]);
    }
    if (drag?.point && channel === 'preview') bulge(mesh, result, place(mesh, drag.point));
    return result;
  }

  scalars(name, pose, positions) {
    const mesh = this.meshes.target;
    const values = new Float32Array(positions.length / 3);
    const phase = (pose?.index ?? 0) / FRAMES;
    for (let v = 0; v < values.length; v++) {
      const [x, y, z] = mesh.positions.subarray(v * 3, v * 3 + 3);
      const wave = Math.abs(Math.sin(5 * x + 3 * phase * 6.28) * Math.cos(4 * y - z));
      if (name === 'point_error') values[v] = 2.4 * wave * Math.max(0, 0.2 - y);
      else if (name === 'edge_stretch') values[v] = 18 * Math.abs(Math.sin(7 * y + 6.28 * phase)) * Math.max(0, -y);
      else if (name === 'component_gaps') values[v] = mesh.positions.length / 3 - v < 400 ? 1.5 : Number.NaN;
      else values[v] = 100 * (1 - wave);
    }
    return values;
  }

  worst() {
    const mesh = this.meshes.target;
    const at = (point) => nearestVertex(mesh.positions, point);
    return [
      {
        pose: 6,
        pose_name: 'Walk 6',
        metric: 'edge_stretch',
        title: 'edge stretch',
        value: 34.2,
        words: 'edge stretch 34.2 %, above 25 %',
        fault: 'parts move where they should rest: give a pair there',
        meaning: 'how far it is from what it should be',
        unit: '%',
        limit: 25,
        level: 'bad',
        about: 'front.L knee',
        vertex: at([0.45, -0.5, 0.12]),
      },
      {
        pose: 18,
        pose_name: 'Walk 18',
        metric: 'edge_stretch',
        title: 'edge stretch',
        value: 22.8,
        words: 'edge stretch 22.8 %, above 25 %',
        fault: 'parts move where they should rest: give a pair there',
        meaning: 'how far it is from what it should be',
        unit: '%',
        limit: 25,
        level: 'doubtful',
        about: 'back.R knee',
        vertex: at([-0.45, -0.5, -0.12]),
      },
      {
        pose: 11,
        pose_name: 'Walk 11',
        metric: 'point_error',
        title: 'point error',
        value: 1.4,
        words: 'point error 1.4 %, above 2 %',
        fault: 'parts move where they should rest: give a pair there',
        meaning: 'how far it is from what it should be',
        unit: '% of the diagonal',
        limit: 2,
        level: 'good',
        about: 'nose',
        vertex: at([1.3, 0.5, 0]),
      },
    ];
  }
}

function kindOf(path) {
  return path.includes('camel') ? 'camel' : 'horse';
}

function stem(file) {
  return file.replace(/\.[^.]*$/, '');
}

function proposals(meshes, kinds) {
  return NAMED[kinds.source].map(([name, point], i) => {
    const confidence = Math.max(0.12, Math.round((0.97 - ((i * 37) % 15) * 0.062) * 100) / 100);
    const source = { vertex: nearestVertex(meshes.source.positions, point) };
    const target = i === 6 ? null : { vertex: nearestVertex(meshes.target.positions, NAMED[kinds.target][i][1]) };
    return {
      name,
      source,
      target,
      status: i < 3 ? 'confirmed' : 'proposed',
      confidence: i < 3 ? null : confidence,
      origin: 'proposed',
    };
  });
}

export function place(mesh, point) {
  if (point.vertex !== undefined) return [...mesh.positions.subarray(point.vertex * 3, point.vertex * 3 + 3)];
  const result = [0, 0, 0];
  for (let corner = 0; corner < 3; corner++) {
    const v = mesh.triangles[point.triangle * 3 + corner];
    for (let i = 0; i < 3; i++) result[i] += mesh.positions[v * 3 + i] * point.barycentric[corner];
  }
  return result;
}

function bulge(mesh, positions, centre) {
  for (let v = 0; v < positions.length / 3; v++) {
    const d = [0, 1, 2].map((i) => mesh.positions[v * 3 + i] - centre[i]);
    const amount = 0.5 * Math.exp(-(d[0] ** 2 + d[1] ** 2 + d[2] ** 2) / 0.02);
    for (let i = 0; i < 3; i++) positions[v * 3 + i] += amount * (d[i] + (i === 1 ? 0.1 : 0));
  }
}
