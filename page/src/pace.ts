// A scene that moves is drawn coarser where frames come too slowly.

const SLOW_MS = 1000 / 30; // a frame that takes longer is slow
const FRAMES = 4; // whose mean is judged
const STEP = 0.75, LEAST = 0.3; // of the pixels across and down
const PAUSE_MS = 250; // a longer time between two frames is a pause of the hand

// A Pace settles the share of a scene's pixels, across and down, that are drawn while it moves.
export class Pace {
  private last = 0;
  private spent = 0;
  private count = 0;
  share: number;

  constructor(private readonly finest: number) {
    this.share = finest;
  }

  // A movement begins: perhaps the machine has more time now.
  begin(): void {
    this.share = Math.min(this.finest, this.share / STEP);
    this.last = this.spent = this.count = 0;
  }

  // In: time_ms: of a frame that was drawn    Out: whether the share has changed
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
