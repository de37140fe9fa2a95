// What stands around the table of parameters: the row of buttons, what is said, and the places of the rest.

import { make, setAttribute, setText } from "../ui/dom";
import { t } from "../words/words";

/** What the buttons do. */
export interface FormActs {
  read(): void;
  write(): void;
  forget(): void;
  save(): void;
  /** Leads to where control is taken. */
  openControl(): void;
}

export interface Form {
  readonly find: HTMLInputElement;
  readonly choice: HTMLSelectElement;
  readonly again: HTMLButtonElement;
  readonly write: HTMLButtonElement;
  readonly forget: HTMLButtonElement;
  readonly save: HTMLButtonElement;
  readonly lead: HTMLButtonElement;
  readonly said: HTMLElement;
  readonly who: HTMLElement;
  readonly empty: HTMLElement;
  readonly confirmBox: HTMLElement;
  readonly tableBox: HTMLElement;
  /** Says what went wrong; empty for nothing. */
  fail(text: string): void;
}

/** The form in `root`; its buttons that change a vessel are there only where the person `may`. */
export function createForm(root: HTMLElement, may: boolean, acts: FormActs): Form {
  const find = make("input", { type: "search", placeholder: t("name or meaning") });
  const choice = choiceOfRows();
  const again = button(t("Read from vessel"), () => acts.read());
  const write = button(t("Write"), () => acts.write(), "main");
  const forget = button(t("Discard changes"), () => acts.forget());
  const save = button(t("Save to vessel …"), () => acts.save());
  const lead = button(t("Control …"), () => acts.openControl());
  const trouble = make("p", { class: "note bad", role: "alert", hidden: "" });
  const said = make("p", { class: "heard", role: "status" });
  const who = make("p", { class: "dim" });
  const confirmBox = make("div");
  const empty = make("p", { class: "empty" }, t("Loading …"));
  const tableBox = make("div", { class: "param-list" });
  const changes = may ? [write, forget, save] : [];
  const row = make("div", { class: "row" }, make("label", {}, `${t("Find")} `, find), make("label", {}, `${t("Show")} `, choice), again, ...changes);
  root.append(make("div", { class: "control params-box" }, row, who, trouble, confirmBox, said, empty, tableBox));
  const fail = (text: string): void => {
    setText(trouble, text);
    setAttribute(trouble, "hidden", text ? null : "");
  };
  return { find, choice, again, write, forget, save, lead, said, who, empty, confirmBox, tableBox, fail };
}

function choiceOfRows(): HTMLSelectElement {
  const options = [["all", t("all")], ["edited", t("changed here")], ["unsaved", t("differs from saved")], ["changed", t("differs from default")]] as const;
  return make("select", {}, ...options.map(([value, text]) => make("option", { value }, text)));
}

function button(text: string, act: () => void, kind = ""): HTMLButtonElement {
  const made = make("button", { type: "button", ...(kind ? { class: kind } : {}) }, text);
  made.addEventListener("click", act);
  return made;
}
