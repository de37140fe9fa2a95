// What pages are made of, as it looks in the palette in force: for who works on them.

import { useEffect, useRef } from "preact/hooks";
import { createMount } from "../components/mount";
import { contrast, hexRgb, PAIRS } from "../state/contrast";
import { createChrome } from "../ui/chrome";
import { type Icon, icon, ICONS } from "../ui/icons";

const SIZES = ["xs", "s", "m", "l", "xl", "2xl", "3xl"];
const SPACES = ["2xs", "xs", "s", "m", "l", "xl", "2xl"];
/** Contrast from which on a colour is for words. */
const TEXT = 4.5;
const PRIORITIES = ["emergency", "alarm", "warning", "caution"];

/** Draws all of it, and again when the palette changes. */
export function startStyle(root: HTMLElement): void {
  createChrome({ messages: ["VehicleState"], events: false, every_ms: 1_000 }, {});
  const draw = createMount(root);
  const all = (): void => draw(<Style key={document.documentElement.dataset["palette"]} />);
  new MutationObserver(all).observe(document.documentElement, { attributeFilter: ["data-palette"] });
  all();
}

function token(name: string): string {
  return getComputedStyle(document.documentElement).getPropertyValue(`--${name}`).trim();
}

function Style() {
  return (
    <>
      <Section title="Colours" about="Ink on its ground, and how many times as light one is as the other. Red, orange and yellow are for alerts.">
        <div class="pairs">{PAIRS.map(([ink, ground, least]) => <Swatch key={`${ink} ${ground}`} ink={ink} ground={ground} text={least >= TEXT} />)}</div>
      </Section>
      <Section title="Text" about="Atkinson Hyperlegible Next; values in digits of one width, so that nothing moves when they change.">
        {SIZES.map((size) => <p key={size} class="sample" data-size={size}><code>--text-{size}</code> 63.440 12° N 10.404 56° E, 1 l I 0 O, blåskjell</p>)}
        <p class="digits"><span class="num">1111111111</span><br /><span class="num">0000000000</span></p>
      </Section>
      <Section title="Distances and corners">
        {SPACES.map((size) => <p key={size} class="distance" data-size={size}><code>--space-{size}</code> {token(`space-${size}`)}</p>)}
        <div class="row">{["s", "m", "l"].map((size) => <div key={size} class="corner" data-size={size}>--radius-{size}</div>)}</div>
        <div class="row">{["over", "ask", "docked"].map((name) => <div key={name} class="corner shadow" data-shadow={name}>--shadow-{name}</div>)}</div>
      </Section>
      <Section title="Icons" about="Strokes in the ink of where they stand.">
        <div class="row">{ICONS.map((name) => <Picture key={name} name={name} />)}</div>
      </Section>
      <Section title="Parts">
        <div class="row"><button type="button">Plain</button><button type="button" class="main">Main</button><button type="button" class="danger">Danger</button><button type="button" disabled>Not now</button><a class="button" href="#main">Link</a></div>
        <div class="row"><label>A field <input value="63.44012" /></label><label>A choice <select><option>Otter</option></select></label></div>
        <p class="note">A note.</p><p class="note warn">A warning, with what to do.</p><p class="note bad">An error, with its remedy.</p>
        <div class="row">{PRIORITIES.map((name) => <span key={name} class="badge" data-priority={name}>{name}</span>)}<span class="tag">a tag</span></div>
        <dl class="tiles"><Tile name="Speed over ground" value="2.9" unit="kn" age="0.4 s" /><Tile name="Heading" value="128°" unit="" age="old: 14 s" old /></dl>
      </Section>
    </>
  );
}

function Section(props: { readonly title: string; readonly about?: string; readonly children: preact.ComponentChildren }) {
  return <section><h2>{props.title}</h2>{props.about && <p class="dim">{props.about}</p>}{props.children}</section>;
}

/** `text`: whether words are written in it; what only edges and lines have is shown as an edge. */
function Swatch({ ink, ground, text }: { readonly ink: string; readonly ground: string; readonly text: boolean }) {
  const box = useRef<HTMLDivElement>(null);
  // A style attribute would be refused by the page's policy; a property set by a script is not.
  useEffect(() => void Object.assign(box.current?.style ?? {}, { [text ? "color" : "borderColor"]: `var(--${ink})`, background: `var(--${ground})` }), [ink, ground, text]);
  const [one, other] = [hexRgb(token(ink)), hexRgb(token(ground))];
  return <div class="pair" ref={box}><strong>{ink}</strong> on {ground}<br />{token(ink)} on {token(ground)}{one && other && `, ${contrast(one, other).toFixed(1)}:1`}</div>;
}

function Picture({ name }: { readonly name: Icon }) {
  const box = useRef<HTMLSpanElement>(null);
  useEffect(() => box.current?.replaceChildren(icon(name)), [name]);
  return <span class="picture"><span ref={box} /> {name}</span>;
}

function Tile(props: { readonly name: string; readonly value: string; readonly unit: string; readonly age: string; readonly old?: boolean }) {
  return (
    <div class="tile" data-old={props.old ? "" : undefined}>
      <dt>{props.name}</dt>
      <dd><span class="reading num">{props.value}</span><span class="unit">{props.unit}</span></dd>
      <dd class="under"><span class="age num">{props.age}</span></dd>
    </div>
  );
}
