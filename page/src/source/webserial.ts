// Any SLCAN adapter on a serial port of this computer (CANable, CANUSB, USBtin and the like).

import { words } from "../words.ts";
import { OPENING, type Listener, type Source } from "./source.ts";

/** The part of the browser's interface that is used. */
export interface SerialPortLike {
  open(options: { baudRate: number }): Promise<void>;
  close(): Promise<void>;
  readable: ReadableStream<Uint8Array> | null;
  writable: WritableStream<Uint8Array> | null;
}

export interface SerialLike {
  requestPort(): Promise<SerialPortLike>;
}

/** Adapters on USB take any rate; those with a real serial line mostly this one. */
const BAUD_RATE = 115_200;

export async function openSerial(serial: SerialLike | undefined, listener: Listener): Promise<Source | string> {
  if (serial === undefined) return words.sources.noSerial;
  let port: SerialPortLike;
  try {
    port = await serial.requestPort();
  } catch {
    return words.sources.serialRefused;
  }
  try {
    await port.open({ baudRate: BAUD_RATE });
  } catch {
    return words.sources.serialBusy;
  }
  if (port.readable === null || port.writable === null) return words.sources.serialBusy;
  const writer = port.writable.getWriter();
  const reader = port.readable.getReader();
  let closed = false;
  const gone = () => {
    if (!closed) listener.gone(words.sources.gone);
    closed = true;
  };
  const send = (bytes: Uint8Array) => void writer.write(bytes).catch(gone);
  send(OPENING);
  listener.opened();
  void (async () => {
    try {
      for (;;) {
        const { value, done } = await reader.read();
        if (done) break;
        listener.bytes(value);
      }
    } catch {
      // unplugged
    }
    gone();
  })();
  return {
    send,
    close: () => {
      closed = true;
      void (async () => {
        await writer.write(new TextEncoder().encode("C\r")).catch(() => undefined);
        writer.releaseLock();
        await reader.cancel().catch(() => undefined);
        reader.releaseLock();
        await port.close().catch(() => undefined);
      })();
    },
  };
}
