// The emulated board, through the server that serves this page.

import { words } from "../words.ts";
import { OPENING, type Listener, type Source } from "./source.ts";

export function openWebSocket(url: string, listener: Listener): Source {
  const socket = new WebSocket(url);
  socket.binaryType = "arraybuffer";
  let closed = false;
  socket.onopen = () => {
    socket.send(OPENING);
    listener.opened();
  };
  socket.onmessage = (event) => listener.bytes(new Uint8Array(event.data as ArrayBuffer));
  socket.onclose = () => {
    if (!closed) listener.gone(words.sources.gone);
  };
  return {
    send: (bytes) => {
      if (socket.readyState === WebSocket.OPEN) socket.send(bytes as BufferSource);
    },
    close: () => {
      closed = true;
      socket.close();
    },
  };
}
