// A Pace lowers the resolution of a moving scene where frames take too long.

const SLOW_MS = 1000 / 30; // a frame that takes longer is slow
const FRAMES = 4; // number of frames whose mean time is judged
const STEP = 0.75, LEAST = 0.3; // a change multiplies the share by STEP, down to LEAST
const PAUSE_MS = 250; // a longer time between two frames is a pause of the user

// A Pace chooses which share of a scene's pixels is drawn, across and down, while the scene moves.
export class Pace {
  private last = 0;
  private spent = 0;
  private count = 0;
  share: number;

  constructor(private readonly finest: number) {
    this.share = finest;
  }

  // Notes that a movement begins. The resolution goes up a step, for the machine may have more time now.
  begin(): void {
    this.share = Math.min(this.finest, this.share / STEP);
    this.last = this.spent = this.count = 0;
  }

  // Notes a frame.    In: time_ms: when it was drawn    Out: whether the share has changed
  addFrame(time_ms: number): boolean {
    const taken = time_ms - this.last;
    const isPause = this.last === 0 || taken > PAUSE_MS;
    this.last = time_ms;
    if (isPause) return false;
    this.spent += taken;
    if (++this.count < FRAMES) return false;
    const isSlow = this.spent / this.count > SLOW_MS;
    this.spent = this.count = 0;
    if (!isSlow || this.share <= LEAST) return false;
    this.share = Math.max(LEAST, this.share * STEP);
    return true;
  }
}
