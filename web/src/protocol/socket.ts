import { signal } from '../ui/signal.ts';
import { type Container, readContainer } from './container.ts';
import type { FrameHeader, FromServer, ToServer } from './types.ts';

export type Connection = 'connecting' | 'open' | 'lost';

const FIRST_DELAY = 250;
const LONGEST_DELAY = 4000;

/** The WebSocket, which connects again for as long as the page is there. */
export class Socket {
  readonly connection = signal<Connection>('connecting');
  onMessage: (message: FromServer) => void = () => {};
  onFrame: (frame: Container<FrameHeader>) => void = () => {};
  /** Called when a connection was lost or refused. */
  onLost: () => void = () => {};
  /** Called at each connection, so that what was missed is fetched. */
  onOpen: () => void = () => {};
  private socket: WebSocket | null = null;
  private delay = FIRST_DELAY;
  private timer = 0;

  connect(): void {
    window.clearTimeout(this.timer);
    const url = new URL('/api/live', location.href);
    url.protocol = location.protocol === 'https:' ? 'wss:' : 'ws:';
    const socket = new WebSocket(url);
    socket.binaryType = 'arraybuffer';
    socket.onopen = () => {
      this.delay = FIRST_DELAY;
      this.connection.value = 'open';
      this.onOpen();
    };
    socket.onmessage = (event: MessageEvent<string | ArrayBuffer>) => this.receive(event.data);
    socket.onclose = () => this.retry();
    this.socket = socket;
  }

  /** Sends a message; while there is no connection it is dropped, since what the page shows is sent anew afterwards. */
  send(message: ToServer): boolean {
    if (this.socket?.readyState !== WebSocket.OPEN) return false;
    this.socket.send(JSON.stringify(message));
    return true;
  }

  private receive(data: string | ArrayBuffer): void {
    if (typeof data === 'string') this.onMessage(JSON.parse(data) as FromServer);
    else this.onFrame(readContainer<FrameHeader>(data));
  }

  private retry(): void {
    this.connection.value = 'lost';
    this.onLost();
    this.timer = window.setTimeout(() => this.connect(), this.delay);
    this.delay = Math.min(this.delay * 1.6, LONGEST_DELAY);
  }
}
