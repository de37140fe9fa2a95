// What fields measure, as people say it: IMC names them by letters (`psi`, `sog`). IMC.xml of LSTS says what each is.

import { t } from "../words/words";

const OF_STATE = {
  phi: () => t("roll"),
  theta: () => t("pitch"),
  psi: () => t("heading"),
  u: () => t("forward speed"),
  v: () => t("sideways speed, to starboard"),
  w: () => t("downward speed"),
  p: () => t("roll rate"),
  q: () => t("pitch rate"),
  r: () => t("rate of turn"),
  x: () => t("distance north of the reference"),
  y: () => t("distance east of the reference"),
  z: () => t("distance below the reference"),
  lat: () => t("latitude of the reference"),
  lon: () => t("longitude of the reference"),
  height: () => t("height of the reference"),
};

/** By message and field; made when they are asked for, for then the words are there. */
export const QUANTITIES: Readonly<Record<string, Readonly<Record<string, () => string>>>> = {
  EstimatedState: {
    ...OF_STATE,
    vx: () => t("speed north"),
    vy: () => t("speed east"),
    vz: () => t("speed down"),
    depth: () => t("depth of the vessel"),
    alt: () => t("height above the bottom"),
    true_lat_deg: () => t("latitude"),
    true_lon_deg: () => t("longitude"),
  },
  SimulatedState: {
    ...OF_STATE,
    svx: () => t("current north"),
    svy: () => t("current east"),
    svz: () => t("current down"),
  },
  GpsFix: {
    lat: () => t("latitude"),
    lon: () => t("longitude"),
    height: () => t("height above the ellipsoid"),
    satellites: () => t("satellites used"),
    cog: () => t("course over ground"),
    sog: () => t("speed over ground"),
    hdop: () => t("horizontal dilution of precision"),
    vdop: () => t("vertical dilution of precision"),
    hacc: () => t("horizontal accuracy"),
    vacc: () => t("vertical accuracy"),
    utc_time: () => t("time of day (UTC)"),
  },
  EulerAngles: {
    phi: () => t("roll"),
    theta: () => t("pitch"),
    psi: () => t("heading"),
    psi_magnetic: () => t("magnetic heading"),
  },
  AngularVelocity: {
    x: () => t("roll rate"),
    y: () => t("pitch rate"),
    z: () => t("rate of turn"),
  },
  Acceleration: {
    x: () => t("acceleration ahead"),
    y: () => t("acceleration to starboard"),
    z: () => t("acceleration down"),
  },
  Rpm: { value: () => t("propeller speed") },
  Voltage: { value: () => t("voltage") },
  Current: { value: () => t("current drawn") },
  Temperature: { value: () => t("temperature") },
  FuelLevel: {
    value: () => t("battery charge"),
    confidence: () => t("confidence in the charge"),
  },
  Pressure: { value: () => t("pressure") },
  Depth: { value: () => t("depth of the vessel") },
  SoundSpeed: { value: () => t("speed of sound in water") },
  Salinity: { value: () => t("salinity") },
  Conductivity: { value: () => t("conductivity") },
  Distance: { value: () => t("distance measured") },
  CpuUsage: { value: () => t("processor load") },
  StorageUsage: {
    available: () => t("free disk space"),
    value: () => t("disk space used"),
  },
  LinkLevel: { value: () => t("link quality") },
  RSSI: { value: () => t("signal strength") },
  DesiredHeading: { value: () => t("desired heading") },
  DesiredHeadingRate: { value: () => t("desired rate of turn") },
  DesiredSpeed: { value: () => t("desired speed") },
  DesiredControl: {
    x: () => t("desired force ahead"),
    n: () => t("desired turning moment"),
  },
  SetThrusterActuation: { value: () => t("thrust command") },
  PathControlState: {
    x: () => t("distance along the track"),
    y: () => t("cross-track error"),
    z: () => t("vertical error"),
    vx: () => t("speed along the track"),
    vy: () => t("speed across the track"),
    course_error: () => t("course error"),
    eta: () => t("time to go on this leg"),
  },
  PlanControlState: {
    plan_progress: () => t("progress of the plan"),
    plan_eta: () => t("time to go of the plan"),
    man_eta: () => t("time to go of the maneuver"),
  },
  VehicleState: {
    error_count: () => t("errors reported"),
    maneuver_eta: () => t("time to go of the maneuver"),
  },
  EstimatedStreamVelocity: {
    x: () => t("current north"),
    y: () => t("current east"),
    z: () => t("current down"),
  },
  AbsoluteWind: {
    direction: () => t("wind direction"),
    speed: () => t("wind speed"),
    turbulence: () => t("turbulence of the wind"),
  },
  TBRFishTag: {
    trans_id: () => t("tag number"),
    trans_data: () => t("sensor value of the tag"),
    SNR: () => t("signal-to-noise ratio"),
    trans_freq: () => t("frequency of the tag"),
    millis: () => t("milliseconds of the time heard"),
    serial_no: () => t("receiver number"),
    lat: () => t("latitude"),
    lon: () => t("longitude"),
  },
  TBRSensor: {
    temperature: () => t("water temperature"),
    avg_noise_level: () => t("mean noise"),
    peak_noise_level: () => t("peak noise"),
    recv_listen_freq: () => t("frequency listened to"),
    serial_no: () => t("receiver number"),
  },
};

/** What a field measures, in the reader's language; empty where only its IMC name is known. */
export function quantity(message: string, field: string): string {
  const fields = Object.hasOwn(QUANTITIES, message) ? QUANTITIES[message] : undefined;
  return fields && Object.hasOwn(fields, field) ? (fields[field]?.() ?? "") : "";
}
