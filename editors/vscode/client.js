// JSON-RPC with `scenario-runner lsp` over its standard input and output. Needs nothing but Node.
"use strict";

const { spawn } = require("child_process");

/** Speaks with a server that it starts. Whoever waits for an answer when the server ends is told so. */
class Client {
  /**
   * @param {string} command the program
   * @param {(method: string, params: any) => void} onNotification
   * @param {(error: Error) => void} onEnd once, when the server could not be started or has ended without being asked to
   * @param {{cwd?: string}} options
   */
  constructor(command, onNotification, onEnd, options = {}) {
    this.waiting = new Map();
    this.next = 1;
    this.buffer = Buffer.alloc(0);
    this.onNotification = onNotification;
    this.ended = false;
    this.leaving = false;
    const end = (error) => {
      if (this.ended) return;
      this.ended = true;
      this.fail(error);
      if (!this.leaving) onEnd(error);
    };
    this.process = spawn(command, ["lsp"], { stdio: ["pipe", "pipe", "inherit"], ...options });
    this.process.on("error", end);
    this.process.on("exit", () => end(new Error("the language server ended")));
    this.process.stdin.on("error", () => {});
    this.process.stdout.on("data", (data) => this.receive(data));
  }

  fail(error) {
    for (const { reject } of this.waiting.values()) reject(error);
    this.waiting.clear();
  }

  send(message) {
    if (this.ended) return;
    const body = Buffer.from(JSON.stringify({ jsonrpc: "2.0", ...message }));
    this.process.stdin.write(`Content-Length: ${body.length}\r\n\r\n`);
    this.process.stdin.write(body);
  }

  notify(method, params) {
    this.send({ method, params });
  }

  request(method, params) {
    if (this.ended) return Promise.reject(new Error("the language server has ended"));
    const id = this.next++;
    return new Promise((resolve, reject) => {
      this.waiting.set(id, { resolve, reject });
      this.send({ id, method, params });
    });
  }

  receive(data) {
    this.buffer = Buffer.concat([this.buffer, data]);
    for (;;) {
      const end = this.buffer.indexOf("\r\n\r\n");
      if (end < 0) return;
      const length = /content-length: *(\d+)/i.exec(this.buffer.toString("ascii", 0, end));
      const start = end + 4;
      const size = length ? Number(length[1]) : 0;
      if (this.buffer.length < start + size) return;
      const message = JSON.parse(this.buffer.toString("utf8", start, start + size));
      this.buffer = this.buffer.subarray(start + size);
      const waiting = this.waiting.get(message.id);
      if (waiting) {
        this.waiting.delete(message.id);
        if (message.error) waiting.reject(new Error(message.error.message));
        else waiting.resolve(message.result);
      } else if (message.method) {
        this.onNotification(message.method, message.params);
      }
    }
  }

  /** Says goodbye; the server ends by itself. */
  async leave() {
    this.leaving = true;
    await this.request("shutdown", null).catch(() => {});
    this.notify("exit", null);
  }
}

module.exports = { Client };
