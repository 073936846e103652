// The sentence that the page says.
import { element } from "../element";

/** What a file says of itself may have megabytes [characters]. */
const LONGEST_SENTENCE = 240;

let silence = 0;

/** Say nothing more, but for what is said for a while. */
export function hush(): void {
  if (silence === 0) say("");
}

/** Say something, for a while or until the next sentence; nothing says nothing. */
export function say(sentence: string, milliseconds = 0): void {
  clearTimeout(silence);
  silence = 0;
  element("message").textContent =
    sentence.length > LONGEST_SENTENCE ? `${sentence.slice(0, LONGEST_SENTENCE)} …` : sentence;
  element("message").hidden = sentence === "";
  if (milliseconds > 0) silence = setTimeout(() => say(""), milliseconds) as unknown as number;
}
