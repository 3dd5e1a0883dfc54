import { readableIn } from '../ui/words.ts';
import { type Arrays, type Container, readContainer, writeContainer } from './container.ts';
import type {
  About,
  ApiError,
  Diagnostic,
  Edit,
  EditResult,
  Folder,
  Job,
  Markers,
  Mask,
  Next,
  OpenRequest,
  Pipeline,
  Session,
  Side,
  Step,
} from './types.ts';

/** The server refused; `error` says why, for people. */
export class RequestError extends Error {
  readonly status: number;
  readonly error: ApiError;
  readonly body: unknown;

  constructor(status: number, error: ApiError, body: unknown) {
    super(error.message);
    this.status = status;
    this.error = error;
    this.body = body;
  }
}

/** No answer came, so it is not known whether the server did it. */
export class ConnectionError extends Error {}

const SECONDS = 1000;

async function request(method: string, path: string, body?: BodyInit, json = false): Promise<Response> {
  const headers = json ? { 'Content-Type': 'application/json' } : undefined;
  let response: Response;
  try {
    response = await fetch(path, { method, body, headers });
  } catch {
    throw new ConnectionError('the server cannot be reached');
  }
  if (response.ok) return response;
  const answer: unknown = await response.json().catch(() => null);
  throw new RequestError(response.status, errorIn(answer, response), answer);
}

function errorIn(answer: unknown, response: Response): ApiError {
  if (answer !== null && typeof answer === 'object' && 'error' in answer) return answer.error as ApiError;
  return {
    code: 'internal',
    message: `the server answered ${response.status} ${response.statusText}`.trim(),
    hint: null,
    diagnostics: [],
  };
}

async function get<T>(path: string): Promise<T> {
  return (await request('GET', path)).json() as Promise<T>;
}

async function send<T>(method: string, path: string, body: unknown): Promise<T> {
  return (await request(method, path, JSON.stringify(body), true)).json() as Promise<T>;
}

async function binary<H>(path: string): Promise<Container<H>> {
  return readContainer<H>(await (await request('GET', path)).arrayBuffer());
}

/** An edit that conflicts in part is an answer, not a failure. */
async function edit(path: string, body: unknown): Promise<EditResult> {
  try {
    return await send<EditResult>('POST', path, body);
  } catch (error) {
    if (error instanceof RequestError && error.status === 409 && hasMarkers(error.body)) return error.body;
    throw error;
  }
}

function hasMarkers(body: unknown): body is EditResult {
  return body !== null && typeof body === 'object' && 'markers' in body;
}

function maskPath(side: Side, name: string): string {
  return `/api/masks/${side}/${encodeURIComponent(name)}`;
}

export const api = {
  session: () => get<Session>('/api/session'),
  mesh: (side: Side) => binary<{ project: number; side: Side }>(`/api/mesh/${side}`),
  files: (path: string | null) =>
    get<Folder>(path === null ? '/api/files' : `/api/files?path=${encodeURIComponent(path)}`),
  open: (what: OpenRequest) => send<Session>('POST', '/api/open', what),
  upload,
  markers: () => get<Markers>('/api/markers'),
  edit: (change: Edit) => edit('/api/markers', change),
  undo: (project: number, base: number) => edit('/api/markers/undo', { project, base }),
  redo: (project: number, base: number) => edit('/api/markers/redo', { project, base }),
  propose: (others?: number) => send<Job>('POST', '/api/markers/propose', { others }),
  next: (after: number | null) => get<Next>(`/api/markers/next${after === null ? '' : `?after=${after}`}`),
  pipeline: () => get<Pipeline>('/api/pipeline'),
  schema: () => get<unknown>('/api/schema'),
  putPipeline: (base: number, text: string) => send<Pipeline>('PUT', '/api/pipeline', { base, text }),
  setValue: (base: number, path: Step[], value: unknown) =>
    send<Pipeline>('POST', '/api/pipeline/set', { base, path, value }),
  undoPipeline: (base: number) => send<Pipeline>('POST', '/api/pipeline/undo', { base }),
  redoPipeline: (base: number) => send<Pipeline>('POST', '/api/pipeline/redo', { base }),
  /** The value of a text in YAML, or what is wrong with it. */
  yaml: (text: string) => send<{ value: unknown; problem: string | null }>('POST', '/api/yaml', { text }),
  unsetValue: (base: number, path: Step[]) => send<Pipeline>('POST', '/api/pipeline/unset', { base, path }),
  run: () => send<Job>('POST', '/api/run', {}),
  jobs: () => get<Job[]>('/api/jobs'),
  cancel: async (id: number) => (await request('DELETE', `/api/jobs/${id}`)).json() as Promise<Job>,
  masks: () => get<{ masks: Mask[] }>('/api/masks'),
  mask: (side: Side, name: string) => binary<object>(maskPath(side, name)),
  saveMask: async (side: Side, name: string, arrays: Arrays, replace: boolean) =>
    (
      await request('PUT', `${maskPath(side, name)}?replace=${replace}`, writeContainer({}, arrays))
    ).json() as Promise<Mask>,
  saveComponents: (side: Side, name: string, components: string[], replace: boolean) =>
    send<Mask>('PUT', `${maskPath(side, name)}/components?replace=${replace}`, { components }),
  deleteMask: async (side: Side, name: string) =>
    (await request('DELETE', maskPath(side, name))).json() as Promise<{ masks: Mask[] }>,
  about: () => get<About>('/api/about'),
};

/** Uploads with progress, which fetch does not tell. */
function upload(file: File, progress: (share: number) => void): Promise<{ path: string; bytes: number }> {
  return new Promise((resolve, reject) => {
    const transfer = new XMLHttpRequest();
    transfer.open('POST', `/api/upload?name=${encodeURIComponent(file.name)}`);
    transfer.responseType = 'json';
    transfer.timeout = 600 * SECONDS;
    transfer.upload.onprogress = (event) => progress(event.total > 0 ? event.loaded / event.total : 0);
    transfer.onload = () => {
      if (transfer.status < 400) resolve(transfer.response);
      else reject(new RequestError(transfer.status, uploadError(transfer), transfer.response));
    };
    transfer.onerror = () => reject(new ConnectionError('the upload was interrupted'));
    transfer.ontimeout = transfer.onerror;
    transfer.send(file);
  });
}

function uploadError(transfer: XMLHttpRequest): ApiError {
  return (
    transfer.response?.error ?? {
      code: 'internal',
      message: `the server answered ${transfer.status}`,
      hint: null,
      diagnostics: [],
    }
  );
}

export interface Failure {
  message: string;
  hint: string | null;
  diagnostics: Diagnostic[];
}

/** What to tell a person about anything that was thrown. */
export function describeError(error: unknown): Failure {
  if (error instanceof RequestError) {
    const { message, hint, diagnostics } = error.error;
    return { message: sentence(message), hint: hint && sentence(hint), diagnostics };
  }
  const message = error instanceof Error ? sentence(error.message) : 'Something went wrong.';
  return { message, hint: null, diagnostics: [] };
}

/** The server's messages have no capital and no full stop, and some words of the command line. */
export function sentence(text: string): string {
  // Names of files and settings keep their case.
  const words = readableIn(text);
  const start = /^[a-z]+[ ,:]/.test(words) ? words.charAt(0).toUpperCase() + words.slice(1) : words;
  return /[.!?…]$/.test(start) ? start : `${start}.`;
}
