// How the first vessel comes in, by each of the ways.

import type { ComponentChildren } from "preact";

export function FirstSteps() {
  const url = `${location.protocol === "https:" ? "wss" : "ws"}://${location.host}/link`;
  return (
    <div class="empty">
      <p><strong>No system has been heard yet.</strong> A vessel appears here with its first packet.</p>
      <h3>A vessel with lutra-agent, by its link</h3>
      <p>An admin names it and makes its link token under <a href="/admin/vessels">Admin, Vessels</a>. The token goes into a file aboard, and its place into the vessel's configuration:</p>
      <Lines>{["[Transports.Lutra]", "Enabled = Always", `URL = ${url}`, "Token File = lutra.token"].join("\n")}</Lines>
      <h3>A vessel with DUNE in the same network, by UDP</h3>
      <p>In the server's configuration, then restart the server:</p>
      <Lines>{'[doors.udp]\nlisten = "0.0.0.0:6001"'}</Lines>
      <p>Aboard, [Transports.Announce] and [Transports.UDP] are enabled: both find each other by their announcements.</p>
      <h3>A vessel with DUNE behind a VPN, by TCP</h3>
      <p>In the server's configuration, with the vessel's address:</p>
      <Lines>{'[doors.tcp]\nconnect = ["10.77.0.10:7001"]'}</Lines>
      <p>Aboard:</p>
      <Lines>{"[Transports.TCP.Server]\nEnabled = Always\nPort = 7001"}</Lines>
      <p>UDP and TCP have no passwords: open them on a VPN or a network of your own only. <a href="/admin/doors">Admin, Connections</a> tells who came in and whom the server refused.</p>
    </div>
  );
}

function Lines({ children }: { readonly children: ComponentChildren }) {
  return <pre class="lines" tabIndex={0}>{children}</pre>;
}
