// The worker that computes, and the pictures asked of it: the newest request wins, small before full size.

/** Longest time a picture may take that follows a hand (ms). */
const FOLLOWING = 90;
/** Longest time that full size is worth when the window decides the size (ms). */
const PATIENCE = 4000;
const SCALES = [1, 1 / 2, 1 / 4, 1 / 8, 1 / 16];

/** Calls into the worker. A worker that died is replaced; its unanswered calls reject with a sentence. */
export class WorkerCalls {
  #module; #worker; #calls = new Map(); #next = 0; #device;

  constructor(module, device) {
    this.#module = module;
    this.#device = device;
  }

  /** Starts the worker. */
  open() {
    this.#worker = new Worker(new URL("worker.js", import.meta.url), { type: "module" });
    this.#worker.onmessage = ({ data }) => this.#answer(data);
    this.#worker.onerror = (event) => { event.preventDefault(); this.#died(event.message); };
    return this.#post("open", [this.#module, this.#device]);
  }

  async call(name, ...parameters) {
    if (!this.#worker) await this.open();
    return this.#post(name, parameters);
  }

  /** Ends what is computed, if anything is: its calls reject. The next call starts another worker. */
  stop() {
    if (this.#calls.size) this.#died("it is no longer wanted");
  }

  #post(name, parameters) {
    return new Promise((resolve, reject) => {
      const id = this.#next++;
      this.#calls.set(id, { resolve, reject });
      this.#worker.postMessage({ id, name, parameters });
    });
  }

  #answer({ id, value, error, dead }) {
    const call = this.#calls.get(id);
    this.#calls.delete(id);
    if (error === undefined) call.resolve(value);
    else call.reject(error);
    if (dead) this.#died(error);
  }

  #died(reason) {
    this.#worker.terminate();
    this.#worker = undefined;
    const calls = [...this.#calls.values()];
    this.#calls.clear();
    for (const call of calls) call.reject(`The computation stopped: ${reason}. The next change starts it again.`);
  }
}

/** Draws whatever was asked for last. */
export class Painter {
  #draw; #wanted; #running = false; #perPixel; #least = Infinity;

  /** Whether full size is worth a thought: on a processor, not on a GPU. */
  isSlow = false;

  /** `draw(job, size, isLast)` computes and shows one picture, of which larger ones follow or not. `failed(sentence)` hears why there is none. */
  constructor(draw, failed) {
    this.#draw = draw;
    this.failed = failed;
  }

  /** The job that nothing newer has replaced. */
  get wanted() { return this.#wanted; }

  /** `job.size` is that of the full picture; `job.exact`: no other size will do; `job.following`: a hand still moves. */
  want(job) {
    this.#wanted = job;
    if (!this.#running) this.idle = this.#run();
  }

  async #run() {
    this.#running = true;
    while (this.#wanted) {
      const job = this.#wanted;
      try {
        await this.#stages(job);
      } catch (error) {
        if (this.#wanted === job) this.failed(error, job);
      }
      if (this.#wanted === job) this.#wanted = undefined;
    }
    this.#running = false;
  }

  async #stages(job) {
    const small = this.#scale(job.size, FOLLOWING);
    if (small < 1 || job.following) await this.#stage(job, small, job.following);
    if (job.following || this.#wanted !== job) return;
    // The hand may come back at once: full size waits for a frame, in which newer wishes arrive.
    await new Promise((resolve) => setTimeout(resolve, 0));
    if (this.#wanted !== job) return;
    const full = job.exact || !this.isSlow ? 1 : Math.max(small, this.#scale(job.size, PATIENCE));
    await this.#stage(job, full, true);
  }

  async #stage(job, scale, last) {
    const size = [Math.max(1, Math.round(job.size[0] * scale)), Math.max(1, Math.round(job.size[1] * scale))];
    const start = performance.now();
    await this.#draw(job, size, last && !job.following);
    const taken = performance.now() - start;
    this.#least = Math.min(this.#least, taken);
    const perPixel = Math.max(0, taken - this.#least) / (size[0] * size[1]);
    // A kernel that was compiled first says little about the next picture.
    this.#perPixel = Math.min(perPixel, 2 * (this.#perPixel ?? perPixel));
  }

  /** The largest scale whose picture takes no longer than that, as far as is known; a quarter before anything is. */
  #scale([width, height], longest) {
    if (this.#perPixel === undefined) return 1 / 4;
    return SCALES.find((scale) => this.#least + this.#perPixel * width * height * scale * scale <= longest) ?? SCALES.at(-1);
  }
}
