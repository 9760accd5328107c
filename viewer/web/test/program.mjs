// Runs livemvs for a test, and speaks its stream without a browser.

import { spawn } from "node:child_process";
import { randomBytes } from "node:crypto";
import http from "node:http";

/** Starts the program; resolves once it has printed the viewer's address. */
export async function start(program, args) {
  const child = spawn(program, args, { stdio: ["ignore", "pipe", "pipe"] });
  let output = "";
  const ended = new Promise((done) => child.on("exit", (code) => done(code)));
  const url = await new Promise((done, failed) => {
    const look = (data) => {
      output += data;
      const match = /viewer: (https?:\S+)/.exec(output);
      if (match) done(match[1]);
    };
    child.stdout.on("data", look);
    child.stderr.on("data", look);
    child.on("exit", (code) => failed(new Error(`livemvs ended with ${code}: ${output}`)));
  });
  return {
    url,
    ended,
    output: () => output,
    /** Holds it where it is, with its sockets open, and lets it go on. */
    hold: () => child.kill("SIGSTOP"),
    release: () => child.kill("SIGCONT"),
    /** Ends it as a crash would. */
    async kill() {
      child.kill("SIGKILL");
      await ended;
    },
    async stop() {
      if (child.exitCode === null) child.kill("SIGINT");
      const late = setTimeout(() => child.kill("SIGKILL"), 10000);
      const code = await ended;
      clearTimeout(late);
      return code;
    },
  };
}

/** Runs tests, { name, body }, in order until one fails, which is told to `failed`; resolves to their
 * number. What follows a failure builds on it. */
export async function runTests(tests, failed) {
  for (const { name, body } of tests) {
    const begin = Date.now();
    try {
      await body();
      console.log(`ok      ${name} (${((Date.now() - begin) / 1000).toFixed(1)} s)`);
    } catch (error) {
      console.log(`FAILED  ${name}: ${error.stack}`);
      await failed();
      return 1;
    }
  }
  return 0;
}

/** GET; resolves to status and headers. */
export function get(url, headers = {}) {
  return new Promise((done, failed) => {
    http
      .get(url, { headers, setHost: !("host" in headers) }, (response) => {
        response.resume();
        response.on("end", () => done({ status: response.statusCode, headers: response.headers }));
      })
      .on("error", failed);
  });
}

/** Opens the stream as a browser would, with headers of one's choice; status 101: `socket` is it. */
export function upgrade(url, headers = {}) {
  const { host, hostname, port, searchParams } = new URL(url);
  return new Promise((done, failed) => {
    const request = http.request({
      hostname,
      port,
      path: "/stream",
      setHost: false,
      headers: {
        host,
        origin: `http://${host}`,
        cookie: `livemvs_${port}=${searchParams.get("token")}`,
        connection: "Upgrade",
        upgrade: "websocket",
        "sec-websocket-version": "13",
        "sec-websocket-key": randomBytes(16).toString("base64"),
        ...headers,
      },
    });
    request.on("upgrade", (response, socket, head) => done({ status: 101, socket, head }));
    request.on("response", (response) => {
      response.resume();
      done({ status: response.statusCode });
    });
    request.on("error", failed);
    request.end();
  });
}

/** Calls `take(type, sequence, payload)` for each record that comes over an upgraded socket. */
export function readRecords({ socket, head }, take) {
  let bytes = head ?? Buffer.alloc(0);
  const frames = () => {
    for (;;) {
      if (bytes.length < 2) return;
      let length = bytes[1] & 127;
      let at = 2;
      if (length === 126) {
        if (bytes.length < 4) return;
        length = bytes.readUInt16BE(2);
        at = 4;
      } else if (length === 127) {
        if (bytes.length < 10) return;
        length = Number(bytes.readBigUInt64BE(2));
        at = 10;
      }
      if (bytes.length < at + length) return;
      const opcode = bytes[0] & 15;
      const message = bytes.subarray(at, at + length);
      bytes = bytes.subarray(at + length);
      if (opcode === 9) pong(socket, message);
      if (opcode !== 2) continue;
      for (let o = 0; o + 20 <= message.length; ) {
        const size = message.readUInt32LE(o + 8);
        take(message.readUInt16LE(o + 4), message.readUInt32LE(o + 12), message.subarray(o + 20, o + 20 + size));
        o += 20 + ((size + 3) & ~3);
      }
    }
  };
  socket.on("data", (data) => {
    bytes = Buffer.concat([bytes, data]);
    frames();
  });
  socket.on("error", () => {});
  frames();
}

function pong(socket, payload) {
  const mask = randomBytes(4);
  const masked = Buffer.from(payload.map((b, i) => b ^ mask[i & 3]));
  socket.write(Buffer.concat([Buffer.from([0x8a, 0x80 | payload.length]), mask, masked]));
}
