# Detections, messages and datasets of a Lutra server, in base R.
#
#   source("lutra.R")
#   server <- lutra("https://shore.example")            # the token stands in LUTRA_TOKEN
#   heard <- lutra_detections(server, start = "2026-06-01", tag = "S256-101")
#   states <- lutra_rows(server, "EstimatedState", vessel = "otter-1", every_s = 1)
#   lutra_download(server, "june.nc", format = "netcdf", start = "2026-06-01", end = "2026-07-01")
#   link <- lutra_link("https://shore.example/s/...", password = "...")
#   lutra_download(link, "salmon.csv")
#
# Times are POSIXct or ISO 8601 text, UTC. A file gets its name once it is whole. Base R can neither go on with a download that was cut nor reckon a
# SHA-256: an interrupted download starts from the beginning; the SHA-256 is checked if the package digest is installed.

lutra <- function(url, token = Sys.getenv("LUTRA_TOKEN")) {
  if (!nzchar(token)) stop("give a token, or put it into the environment as LUTRA_TOKEN")
  structure(list(base = .lutra_base(url), headers = c(Authorization = paste("Bearer", token)), is_link = FALSE), class = "lutra")
}

lutra_link <- function(url, password = Sys.getenv("LUTRA_LINK_PASSWORD"), token = Sys.getenv("LUTRA_TOKEN")) {
  for_account <- grepl("/s/account-[0-9]+/?$", url)
  if (!for_account && !grepl("/s/[0-9a-fA-F]+/?$", url)) stop("a link looks like https://.../s/ and 64 digits, or https://.../s/account- and a number")
  if (for_account && !nzchar(token)) stop("this link is for an account: give a token of it, or put it into LUTRA_TOKEN")
  headers <- if (for_account) c(Authorization = paste("Bearer", token)) else if (nzchar(password)) c("Lutra-Link-Password" = password) else character()
  structure(list(base = .lutra_base(url), headers = headers, is_link = TRUE), class = "lutra")
}

# A table of detections; of a link, those that it gives.
lutra_detections <- function(server, ...) {
  file <- tempfile(fileext = ".csv")
  on.exit(unlink(file))
  lutra_download(server, file, format = "lutra", ...)
  heard <- .lutra_table(file)
  for (name in intersect(c("heard_utc", "reported_utc", "received_utc"), names(heard))) heard[[name]] <- .lutra_time(heard[[name]])
  heard
}

# The rows of any message, such as EstimatedState.
lutra_rows <- function(server, message, vessel = NULL, entity = NULL, field = NULL, start = NULL, end = NULL, every_s = NULL, angles = "rad") {
  .lutra_no_link(server)
  query <- list(message = message, vessel = .lutra_words(vessel), entity = .lutra_words(entity), field = .lutra_words(field),
                from = .lutra_iso(start), to = .lutra_iso(end), every_s = every_s, angles = angles, units = "false")
  file <- tempfile(fileext = ".csv")
  on.exit(unlink(file))
  .lutra_fetch(server, .lutra_url(server, "/api/v1/export.csv", query), file)
  rows <- .lutra_table(file)
  if ("time" %in% names(rows)) rows$time <- .lutra_time(rows$time)
  rows
}

# A file of detections in any format that the server knows. sha256: what its bytes must have.
lutra_download <- function(server, path, format = "lutra", start = NULL, end = NULL, vessel = NULL, tag = NULL, project = NULL, area = NULL,
                           sha256 = NULL) {
  asked <- list(from_us = .lutra_us(start), to_us = .lutra_us(end), vessel = .lutra_words(vessel), tag = .lutra_words(tag),
                project = project, area = area)
  asked <- Filter(Negate(is.null), asked)
  if (server$is_link && length(asked)) stop("a link gives what it gives, and takes no question")
  where <- if (server$is_link) "/detections.csv" else "/api/v1/detections.csv"
  .lutra_verified(server, .lutra_url(server, where, c(asked, list(format = format))), path, sha256)
}

# A published version of a dataset.
lutra_dataset <- function(server, path, dataset, version, format = "lutra", sha256 = NULL) {
  .lutra_no_link(server)
  where <- sprintf("/api/v1/datasets/%d/versions/%d/detections.csv", as.integer(dataset), as.integer(version))
  .lutra_verified(server, .lutra_url(server, where, list(format = format)), path, sha256)
}

.lutra_base <- function(url) {
  if (!grepl("^https?://", url)) stop("an address begins with https:// (or http:// in one's own network)")
  sub("/+$", "", url)
}

.lutra_no_link <- function(server) if (server$is_link) stop("a link gives one dataset; ask a server for this")

.lutra_url <- function(server, path, query = list()) {
  query <- Filter(Negate(is.null), query)
  # A parameter with several values is given once for each.
  one <- function(name, value) paste0(name, "=", vapply(as.character(value), utils::URLencode, "", reserved = TRUE))
  words <- unlist(mapply(one, names(query), query, SIMPLIFY = FALSE))
  paste0(server$base, path, if (length(words)) paste0("?", paste(words, collapse = "&")))
}

.lutra_fetch <- function(server, url, path) {
  part <- paste0(path, ".part")
  on.exit(unlink(part))
  # A redirection could take the token elsewhere, but base R follows it: name the server by its own address.
  status <- tryCatch(
    utils::download.file(url, part, mode = "wb", quiet = TRUE, method = "libcurl", headers = server$headers),
    # The address of a link is a secret, and R's own words would show it.
    warning = function(problem) stop("the server refused, was not reached, or cut the file", call. = FALSE),
    error = function(problem) stop("the server refused, or was not reached", call. = FALSE)
  )
  if (status != 0 || !file.rename(part, path)) stop("the file is not whole, or cannot be named ", path, call. = FALSE)
  invisible(path)
}

.lutra_verified <- function(server, url, path, sha256) {
  if (!is.null(sha256) && !requireNamespace("digest", quietly = TRUE)) stop("to compare a SHA-256, install the package digest")
  .lutra_fetch(server, url, path)
  if (!is.null(sha256) && !identical(digest::digest(file = path, algo = "sha256"), tolower(sha256))) {
    unlink(path)
    stop("these are not the bytes that were published: the archive has changed since, or another version of Lutra writes them")
  }
  invisible(path)
}

.lutra_table <- function(file) {
  table <- utils::read.csv(file, check.names = FALSE, na.strings = "", encoding = "UTF-8", stringsAsFactors = FALSE)
  if (nrow(table) && any(grepl("^#ERROR", table[[1]]))) stop("the table was cut: ", grep("^#ERROR", table[[1]], value = TRUE)[1])
  table
}

.lutra_time <- function(text) as.POSIXct(sub("Z$", "", as.character(text)), format = "%Y-%m-%dT%H:%M:%OS", tz = "UTC")

.lutra_moment <- function(when) if (inherits(when, "POSIXct")) when else as.POSIXct(sub("Z$", "", when), tz = "UTC", tryFormats = c("%Y-%m-%dT%H:%M:%OS", "%Y-%m-%d"))

.lutra_us <- function(when) if (!is.null(when)) format(round(as.numeric(.lutra_moment(when)) * 1e6), scientific = FALSE, trim = TRUE, nsmall = 0)

.lutra_iso <- function(when) if (!is.null(when)) format(.lutra_moment(when), "%Y-%m-%dT%H:%M:%OS3Z", tz = "UTC")

.lutra_words <- function(words) if (!is.null(words)) paste(words, collapse = ",")
