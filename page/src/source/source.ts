// Where data comes from: one interface for a board over WebSocket, an adapter over WebSerial, and a recording.

export interface Listener {
  /** Bytes of an SLCAN line. */
  bytes(bytes: Uint8Array): void;
  /** The source is open, or gone for a reason. */
  opened(): void;
  gone(reason: string): void;
}

export interface Source {
  /** Sends bytes of an SLCAN line; null where nothing can be commanded. */
  send: ((bytes: Uint8Array) => void) | null;
  close(): void;
}

/** Close, 500 kbit/s, open: what every SLCAN adapter understands. */
export const OPENING = new TextEncoder().encode("C\rS6\rO\r");
