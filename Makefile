# Lutra's chores. Each target sets up what it needs and says what it does.

.PHONY: help rust tools check test test-long demo demo-vessel interop bench fuzz fmt audit setup web types chromium agent-aarch64 test-aarch64 packages packages-arm64 test-packages test-containers bench-routes
.DEFAULT_GOAL := help

# What the tests may not miss: see crates/testkit/src/needs.rs. .ci/run adds what `make tools` installs.
LUTRA_REQUIRED ?= browser,agent

# Seconds that `make fuzz` spends on each target.
FUZZ_SECONDS ?= 60
FUZZ_TARGETS := $(patsubst fuzz/fuzz_targets/%.rs,%,$(wildcard fuzz/fuzz_targets/*.rs))

say = @printf '\n== %s\n' "$(1)"

help:
	@echo "make check   the quick look: formatting, lints, and the tests that need no browser and no second program"
	@echo "make test    check formatting, lints, all tests and the documentation"
	@echo "make test-long  the tests that take minutes: a day on a bad link, pictures of all pages, 150 squares in wind and current"
	@echo "make web     check and bundle the pages' scripts and styles into web/dist"
	@echo "make types   write web/src/api/types.gen.ts again from crates/api"
	@echo "make demo    start a shore server and three simulated Otters that sail before a browser, until Ctrl-C"
	@echo "make demo-vessel  sail one simulated Otter through a short plan and look into its log"
	@echo "make interop sail a scripted mission with pyimclsts (from PyPI) as the console"
	@echo "make bench   measure and print speeds; bench-routes those of routes alone"
	@echo "make fuzz    let each parser meet random bytes for FUZZ_SECONDS=$(FUZZ_SECONDS)"
	@echo "make agent-aarch64  build lutra-agent for the Raspberry Pi 4 with Debian's compilers, in /tmp/lutra-aarch64"
	@echo "make test-aarch64   run its tests and those of devices, drivers and onboard as the Pi would, under qemu-user"
	@echo "make packages        Debian packages of lutra-server, lutra-agent and imc, into target/packages; packages-arm64 for the Pi"
	@echo "make test-packages   install, upgrade, remove and purge them in a fresh Debian, made by debootstrap"
	@echo "make test-containers the images and compose files of docker/, built on the same Debian by buildah and run without docker"
	@echo "make audit   check licences, sources and duplicates of all dependencies"
	@echo "make fmt     format the code"

# Needs nothing but a Rust toolchain; everything else is installed through cargo, npm and apt.
rust:
	@command -v cargo >/dev/null || { \
	  echo "Lutra needs Rust $$(sed -n 's/^rust-version = "\(.*\)"/\1/p' Cargo.toml) or newer with rustfmt and clippy: https://rustup.rs"; exit 1; }

setup: rust
	@cargo nextest --version >/dev/null 2>&1 || { \
	  echo "Installing cargo-nextest, the test runner (once, some minutes)"; \
	  cargo install cargo-nextest --locked; }

# npm comes with Node 20 or newer; everything else of the pages through npm, once for each package-lock.json.
web:
	@command -v npm >/dev/null || { \
	  echo "Installing Node and npm (once)"; apt-get update -q && apt-get install -qy nodejs npm; }
	$(call say,Scripts and styles of the pages)
	@cd web && { [ node_modules/.package-lock.json -nt package-lock.json ] || npm ci --no-audit --no-fund; }
	cd web && npm run --silent check && npm run --silent build

types:
	LUTRA_WRITE_TYPES=1 cargo test --quiet --locked --package api

chromium:
	@{ command -v chromium && command -v chromium-headless-shell; } >/dev/null || { \
	  echo "Installing Chromium, for the tests of the pages (once)"; \
	  apt-get update -q && apt-get install -qy --no-install-recommends chromium && { \
	    apt-get install -qy --no-install-recommends chromium-headless-shell || \
	    echo "Chromium without its headless shell: the tests of the pages take longer"; }; }

# For the tests of tunnels, clocks, InfluxDB, MQTT, PostgreSQL, gpsd and nginx, which are skipped and named at the end where these are absent.
tools:
	@for tool in openvpn wireguard-go wg nft ip influxd mosquitto mosquitto_sub gpsd gpsdecode nginx; do command -v $$tool >/dev/null || missing=yes; done; \
	ls /usr/lib/*/faketime/libfaketimeMT.so.1 >/dev/null 2>&1 || missing=yes; \
	ls /usr/lib/postgresql/*/bin/initdb >/dev/null 2>&1 || missing=yes; \
	[ -z "$$missing" ] || { \
	  echo "Installing OpenVPN, WireGuard, libfaketime, InfluxDB, Mosquitto, PostgreSQL, gpsd and nginx, for tests with the real ones (once)"; \
	  apt-get update -q && apt-get install -qy --no-install-recommends \
	    openvpn wireguard-go wireguard-tools nftables iproute2 openssl libfaketime influxdb mosquitto mosquitto-clients postgresql gpsd gpsd-clients nginx-light; } || \
	  echo "not installed: what needs them is skipped and says so"

# A server's own tests need the pages' scripts.
check: setup web
	$(call say,Formatting)
	cargo fmt --all --check
	$(call say,Lints)
	cargo clippy --workspace --all-targets --locked -- -D warnings
	$(call say,Tests of one program without a browser)
	cargo nextest run --workspace --locked --lib --bins -E 'not test(/browser_tests::|hostile_tests::|_in_a_browser/)'

# Twice as many tests at a time as there are processors and one more, as many wait for clocks and the network: see
# .config/nextest.toml.
test: setup web chromium tools
	$(call say,Formatting)
	cargo fmt --all --check
	$(call say,Lints)
	cargo clippy --workspace --all-targets --locked -- -D warnings
	$(call say,Tests of the scripts)
	cd web && npm run --silent test
	$(call say,Tests)
	@rm -f target/skipped
	LUTRA_REQUIRED=$(LUTRA_REQUIRED) LUTRA_SKIPPED=$(CURDIR)/target/skipped \
	  cargo nextest run --workspace --locked --no-fail-fast --test-threads $$(( $$(nproc) * 2 + 1 ))
	@[ ! -e target/skipped ] || { echo "Skipped, for this computer lacks what they need:"; sort target/skipped | uniq -c; }
	$(call say,Examples in the documentation)
	cargo test --doc --workspace --locked --quiet
	$(call say,Documentation)
	RUSTDOCFLAGS="-D warnings" cargo doc --workspace --no-deps --locked --quiet

# What `make test` does by a short form: a day of faults on the link, ten thousand plans judged ashore and aboard, and
# every state of the pages in all palettes, with pictures in target/screenshots. Then, optimised and each by its name:
# what is ignored elsewhere is a benchmark.
test-long: setup web chromium
	$(call say,Long forms of the tests)
	LUTRA_LONG=1 LUTRA_PICTURES=1 LUTRA_FUZZ_ROUNDS=20 LUTRA_REQUIRED=browser,agent \
	  cargo nextest run --workspace --locked --no-fail-fast \
	  -E 'package(link) | test(ashore_and_aboard_agree) | test(/browser_tests::|hostile_tests::|_in_a_browser|^teleop::/) | test(work_goes_on_behind) | test(whenever_months_are_compressed) | test(tables_taken_elsewhere) | test(a_chart_comes_aboard_although) | test(a_cut_and_another_address)'
	$(call say,75 squares in wind and current with each controller)
	cargo test --release --locked --package vehicle-agent --bin lutra-agent -- --ignored --nocapture \
	  seventy_five_weathers_fail_no_plan_with_either_controller

# LUTRA_DEMO_SECONDS=30 ends it by itself, 30 s after all Otters have begun to sail.
demo: rust web
	$(call say,Building)
	cargo build --release --locked --package server --package vehicle-agent
	$(call say,Three Otters before a browser)
	@exec target/release/lutra-server demo

demo-vessel: rust
	$(call say,Building)
	cargo build --release --locked --package vehicle-agent --package imc-cli
	@sh scripts/demo-vessel

interop: setup
	$(call say,A mission by a foreign console)
	@sh scripts/interop-pyimclsts

# Routes alone: all tables of the planner in BENCHMARKS.md.
bench-routes:
	@sh scripts/bench-routes

bench: setup web chromium
	$(call say,Speeds on one core)
	cargo bench --locked --package imc --bench imc
	@sh scripts/bench-pyimclsts
	cargo bench --locked --package charts --bench charts
	cargo bench --locked --package mission --bench guard
	@sh scripts/bench-routes
	cargo bench --locked --package onboard --bench routes
	@command -v ogr2ogr >/dev/null || { \
	  echo "Installing GDAL (135 MB, once), to import the same cells beside"; \
	  apt-get update -q && apt-get install -qy --no-install-recommends gdal-bin; } || \
	  echo "not installed: what needs it is skipped and says so"
	cargo bench --locked --package chartdb --bench chartdb
	cargo bench --locked --package store --bench store
	cargo bench --locked --package hub --bench hub
	cargo bench --locked --package shore --bench app_db
	cargo bench --locked --package server --bench relay
	cargo bench --locked --package server --bench stop
	cargo bench --locked --package server --bench tiles
	@sh scripts/bench-coast
	@sh scripts/bench-detections
	@sh scripts/bench-agent
	cargo test --release --locked --package onboard --test integration drives -- --ignored --nocapture
	cargo test --release --locked --package shore --test postgres -- --ignored --nocapture
	@sh scripts/bench-live
	$(call say,The pages in a browser)
	@sh scripts/bench-pages

fuzz: setup
	@cargo fuzz --version >/dev/null 2>&1 || { \
	  echo "Installing cargo-fuzz (once, some minutes)"; cargo install cargo-fuzz --locked; }
	@for target in $(FUZZ_TARGETS); do \
	  printf '\n== Fuzzing %s for %s s\n' "$$target" "$(FUZZ_SECONDS)"; \
	  mkdir -p fuzz/corpus/$$target; \
	  : the reader of shapefiles tries to reserve what a file claims and fills only what it has; \
	  at_once=2048; asan=; [ $$target != lakes ] || { at_once=1000000; asan=allocator_may_return_null=1; }; \
	  ASAN_OPTIONS=$$asan RUSTC_BOOTSTRAP=1 cargo fuzz run $$target fuzz/corpus/$$target fuzz/seeds/$$target -- \
	    -max_total_time=$(FUZZ_SECONDS) -timeout=60 -rss_limit_mb=2048 -malloc_limit_mb=$$at_once \
	    -print_final_stats=1 || exit 1; \
	done

audit: setup
	@cargo deny --version >/dev/null 2>&1 || { \
	  echo "Installing cargo-deny (once, some minutes)"; cargo install cargo-deny --locked; }
	cargo deny --all-features check licenses bans sources

fmt:
	cargo fmt --all

agent-aarch64: rust
	scripts/agent-aarch64 build

# The unit tests; those that start programs of their own are for the Pi itself.
test-aarch64: rust
	scripts/agent-aarch64 test --lib --bins

packages: rust web
	@scripts/packages

packages-arm64: rust web
	@scripts/packages arm64

test-packages: packages
	@scripts/try-packages

# The programs that the images get are those of the packages.
test-containers: packages
	@scripts/try-containers
