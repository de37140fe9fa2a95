// How the first vessel comes in, by each of the ways.

import type { ComponentChildren } from "preact";
import { t } from "../words/words";

/** The place of a link in a text. */
const LINK = "\u0001";

export function FirstSteps() {
  const url = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/link`;
  return (
    <div class="empty">
      <p><strong>{t("No system has been heard yet.")}</strong>{" "}{t("A vessel appears here with its first packet.")}</p>
      <h3>{t("A vessel with lutra-agent, by its link")}</h3>
      <p><Around text={t("An admin names it and makes its link token under {link}. The token goes into a file aboard, and its place into the vessel's configuration:", { link: LINK })}><a href="/admin/vessels">{t("Admin, Vessels")}</a></Around></p>
      <Lines>{["[Transports.Lutra]", "Enabled = Always", `URL = ${url}`, "Token File = lutra.token"].join("\n")}</Lines>
      <h3>{t("A vessel with DUNE in the same network, by UDP")}</h3>
      <p>{t("In the server's configuration, then restart the server:")}</p>
      <Lines>{'[transports.udp]\nlisten = "0.0.0.0:6001"'}</Lines>
      <p>{t("Aboard, [Transports.Announce] and [Transports.UDP] are enabled: both find each other by their announcements.")}</p>
      <h3>{t("A vessel with DUNE behind a VPN, by TCP")}</h3>
      <p>{t("In the server's configuration, with the vessel's address:")}</p>
      <Lines>{'[transports.tcp]\nconnect = ["10.77.0.10:7001"]'}</Lines>
      <p>{t("Aboard:")}</p>
      <Lines>{"[Transports.TCP.Server]\nEnabled = Always\nPort = 7001"}</Lines>
      <p><Around text={t("UDP and TCP have no passwords: open them on a VPN or a network of your own only. {link} tells who came in and whom the server refused.", { link: LINK })}><a href="/admin/connections">{t("Admin, Connections")}</a></Around></p>
      <p><a href="/help/deployment#aboard">{t("Read more in the manual")}</a></p>
    </div>
  );
}

function Lines({ children }: { readonly children: ComponentChildren }) {
  return <pre class="lines" tabIndex={0}>{children}</pre>;
}

/** A text around the link that stands in the place of {@link LINK}: each language puts it where it belongs. */
function Around({ text, children }: { readonly text: string; readonly children: ComponentChildren }) {
  const [before, behind] = text.split(LINK);
  return <>{before}{children}{behind}</>;
}
