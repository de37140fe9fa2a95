# Checks lutra.R against a running server: `Rscript against_server.R LUTRA_R URL LINK PASSWORD DATASET ROWS`, with LUTRA_TOKEN
# and LUTRA_ACCOUNT_LINK set.
# Run by `server/tests/integration/clients.rs`.

given <- commandArgs(trailingOnly = TRUE)
source(given[1])
url <- given[2]; link <- given[3]; password <- given[4]; dataset <- as.integer(given[5]); rows <- as.integer(given[6])
refused <- function(code) inherits(tryCatch(code, error = identity), "error")

server <- lutra(url)
heard <- lutra_detections(server)
stopifnot(nrow(heard) == rows, inherits(heard$heard_utc, "POSIXct"), is.numeric(heard[["latitude [deg]"]]))
first <- as.numeric(as.POSIXct("2024-11-21 08:00:00", tz = "UTC")) + 0.007
stopifnot(abs(as.numeric(heard$heard_utc[1]) - first) < 1e-4, heard$tag[1] == "S256-101", heard[["snr [dB]"]][1] == 20, is.na(heard$animal[1]))
some <- lutra_detections(server, tag = "S256-101")
stopifnot(nrow(some) > 0, nrow(some) < rows, all(some$tag == "S256-101"))
part <- lutra_detections(server, start = "2024-11-21T08:00:10Z", end = as.POSIXct("2024-11-21 08:00:20", tz = "UTC"))
stopifnot(nrow(part) == 10)

states <- lutra_rows(server, "EstimatedState", vessel = "0x0814", angles = "deg")
stopifnot(nrow(states) == 3, abs(states$lat[1] - 63.44) < 1e-9, inherits(states$time, "POSIXct"))
second <- lutra_rows(server, "EstimatedState", start = "2024-11-21T08:00:01Z", end = "2024-11-21T08:00:02Z")
stopifnot(nrow(second) == 1)

whole <- tempfile(); version <- tempfile(); shared <- tempfile()
lutra_download(server, whole)
lutra_dataset(server, version, dataset, 1)
lutra_download(lutra_link(link, password), shared)
bytes <- function(path) readBin(path, "raw", file.size(path))
stopifnot(identical(bytes(whole), bytes(version)), identical(bytes(whole), bytes(shared)))
mine <- tempfile()
lutra_download(lutra_link(Sys.getenv("LUTRA_ACCOUNT_LINK")), mine)
stopifnot(identical(bytes(whole), bytes(mine)))
parquet <- tempfile()
lutra_download(server, parquet, format = "parquet")
stopifnot(identical(rawToChar(bytes(parquet)[1:4]), "PAR1"))

missing <- tempfile()
stopifnot(
  refused(lutra_download(lutra(url, token = strrep("0", 64)), missing)),
  refused(lutra_download(lutra_link(link, "a wrong password"), missing)),
  refused(lutra_rows(server, "EstimatedStat")),
  refused(lutra_download(lutra_link(link, password), missing, tag = "S256-101")),
  refused(lutra_link("https://shore.example/datasets/1")),
  refused(lutra("ftp://shore.example")),
  !file.exists(missing), !file.exists(paste0(missing, ".part"))
)
cat("all as it should be\n")
