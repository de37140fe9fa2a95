// Alarms where this page is not looked at: in the tab's title always, and by the system's notifications where a person
// has turned sound on and allowed them.

/** The title without alarms, as the page was made; pages do not change it. */
const TITLE = document.title;

export interface Notifier {
  /** Asks the person, after a press; does nothing where it was answered before. */
  ask(): void;
  /** Tells the system, while the page is hidden. One of the same `tag` takes the place of the one before. */
  notify(tag: string, text: string): void;
  /** What the title begins with; empty for nothing. */
  title(mark: string): void;
}

export function createNotifier(): Notifier {
  return {
    ask() {
      if ("Notification" in window && Notification.permission === "default") void Notification.requestPermission();
    },
    notify(tag, text) {
      if (!document.hidden || !("Notification" in window) || Notification.permission !== "granted") return;
      // Phones show only those of a worker.
      void navigator.serviceWorker?.getRegistration().then((worker) => worker?.showNotification("Lutra", { body: text, tag, data: location.href, icon: "/static/icon-192.png" }));
    },
    title(mark) {
      const title = mark ? `${mark} · ${TITLE}` : TITLE;
      if (document.title !== title) document.title = title;
    },
  };
}
