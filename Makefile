# One command from a fresh clone: `make demo` shows it at work, `make test` checks everything.
# Needs Rust 1.95, Python 3.11, Node 20.19 (for the player), and compilers for C and C++.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Blender's module for Python 3.11, apart from ours.
BLENDER := .venv-blender
PYTHON3_11 ?= python3.11
OUT := out
# The Stanford bunny, for figure 6.
BUNNY := $(OUT)/figures/bunny.obj
# The picture shows the wall in mid-break.
DEMO_FRAME := 14

RUST_SOURCES := Cargo.toml Cargo.lock $(shell find crates -type f -not -path '*/tests/*')
PYTHON_SOURCES := pyproject.toml $(wildcard README.md) $(shell find python/frangible -name '*.py' -o -name '*.pyi' -o -name py.typed -o -name '*.json' -o -name '*.usda' -o -name 'live_widget.js')

# What `make build` installs, and the extras of pyproject.toml that are in it.
LOCK := python/requirements.lock
LOCKED := exact gltf usd film plot completion alembic notebook dev

# What `--out FILE.html` writes a recording into.
PLAYER := python/frangible/player.html
PLAYER_SOURCES := $(filter-out web/package%,$(wildcard web/*.*)) $(shell find web/src web/npm/src -type f)

# What goes to crates.io, in the order in which each needs those before it.
CRATES := frangible-math frangible-geometry frangible-bodies frangible-collision frangible-fracture frangible-dynamics frangible

# The engine as a page loads it, and the page.
ENGINE := web/engine
VECTORS := +simd128
PLAYGROUND := web/dist/playground/playground.html

# The package for npm: the engine, its types, and its view for three.js.
NPM := web/npm/dist/three.js
NPM_SOURCES := $(shell find web/npm/src -type f) web/npm/build.mjs web/npm/tsconfig.json web/npm/package.json

.PHONY: help build lock web npm site publish-check demo verify claims gallery figures-table performance soak resume oracle edited-worlds explore test test-rust test-python test-web test-wasm test-blender clean

help: ## List the targets
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "%-12s %s\n", $$1, $$2 }' Makefile

build: $(VENV)/.installed ## Build the Python package into .venv

demo: build ## Simulate the wall; write a page that plays it, USD, glTF and a picture to out/
	@mkdir -p $(OUT)
	$(BIN)/frangible run wall --out $(OUT)/wall.html --out $(OUT)/wall.usdc --out $(OUT)/wall.glb \
	  --out $(OUT)/wall.png --frame $(DEMO_FRAME)
	@echo "Open $(OUT)/wall.html in a browser: it plays the wall."

verify: build ## Measure what the paper and we promise, on this machine
	$(BIN)/frangible verify

claims: build ## Measure it and write the table of docs/claims.md anew
	@mkdir -p $(OUT)
	$(BIN)/frangible verify > $(OUT)/claims.txt
	grep -v '^|' docs/claims.md > $(OUT)/claims.md
	cat $(OUT)/claims.md $(OUT)/claims.txt > docs/claims.md

# Hours, most of them for figure 1 at 3000 steps a second.
gallery: build $(BUNNY) ## Make the pictures of shots and patterns in docs/images anew
	$(BIN)/python bench/gallery.py --mesh $(BUNNY)

figures-table: build $(BUNNY) ## Time the paper's figures and write the table of docs/figures.md anew
	$(BIN)/python bench/figure_speed.py --mesh $(BUNNY)

# Other engines are measured by `frangible bench --peers`, and by bench/curve.py.
performance: build ## Time the piles and write their table in docs/performance.md anew
	$(BIN)/python bench/pile_stages.py

soak: ## Check what takes minutes: figure 8 with 100 and 1000 balls
	cargo test --release --locked -p frangible-shots --test fractures -- --ignored --nocapture

resume: build ## Kill a run of rain-100 at ten random places: it goes on to the same bits; minutes
	$(BIN)/python python/tests/kill_and_resume.py rain-100 10

oracle: ## Compare contacts with an oracle in a million pairs of every two shapes: hours
	ORACLE_PAIRS=$${ORACLE_PAIRS:-1000000} cargo test --release --locked -p frangible-collision --lib \
	  a_million_pairs -- --ignored --nocapture

edited-worlds: ## Edit random worlds as they run, and tell what is lost, stalls or panics
	WORLDS=$${WORLDS:-1000} cargo test --release --locked -p frangible --test edited_worlds -- --nocapture

explore: ## Check properties on other cases than the tests draw, from the seed it prints
	seed=$$(date +%s); echo "PROPTEST_RNG_SEED=$$seed"; \
	  PROPTEST_RNG_SEED=$$seed cargo test --release --workspace --locked

test: test-rust test-python test-web ## Check everything, as continuous integration does

test-rust: tests/tools/node_modules/.package-lock.json
	cargo fmt --check
	cargo clippy --workspace --all-targets --locked -- -D warnings
	cargo test --workspace --locked --test '*'
	cargo test --workspace --locked --doc
	@# All but those with kernels, with the Python module, so that features and what is compiled stay the same.
	cargo test --workspace --locked --lib --exclude frangible-bodies --exclude frangible-collision \
	  --exclude frangible-dynamics
	cargo test --package frangible-bodies --package frangible-collision --package frangible-dynamics \
	  --locked --lib --profile unit

test-python: build tests/tools/node_modules/.package-lock.json
	$(BIN)/mypy
	$(BIN)/stubtest frangible._frangible
	$(BIN)/pytest

test-web: web/node_modules/.package-lock.json $(PLAYGROUND) $(NPM) tests/tools/node_modules/.package-lock.json
	cd web && npm test --silent

web: $(PLAYGROUND) ## Build the engine for browsers, and the page to break things in: web/dist/playground

npm: $(NPM) ## Build the package for npm: web/npm, for `npm pack`

# The gallery plays what this machine simulates: some minutes the first time.
site: $(VENV)/.installed $(PLAYGROUND) $(BUNNY) tests/tools/node_modules/.package-lock.json ## Build playground, gallery and documentation as one folder: out/site
	for shot in $$(node -p 'Object.values(require("./web/site/figures.json")).flatMap(Object.keys).join(" ")'); do \
	  test $(OUT)/figures/$$shot.html -nt $(VENV)/.installed || $(BIN)/frangible run $$shot --quiet \
	    $$(test $$shot = bunny && echo --mesh $(BUNNY)) --out $(OUT)/figures/$$shot.html || exit 1; \
	done
	cd web && node site/build.mjs dist/playground ../$(OUT)/figures ../$(OUT)/site

# Nothing is published. Crates that wait for one another on crates.io are packed, and not compiled from there.
publish-check: build $(NPM) ## Pack crates, wheel and npm package as for publishing, and look at what is in them
	cargo package --locked --no-verify --allow-dirty $(foreach crate,$(CRATES),--package $(crate))
	ls -l target/package/*.crate target/wheels/*.whl
	cd web && node npm/check.mjs

# Vectors are tested with the page; this takes minutes to compile, so `make test` leaves it out.
test-wasm: $(PLAYGROUND) ## Check that WebAssembly without vectors ends in the same states too
	$(MAKE) ENGINE=out/engine-without-vectors VECTORS=-simd128 out/engine-without-vectors/engine_bg.wasm
	cd web && npm run bundle --silent && ENGINE=../../out/engine-without-vectors node --test test/engine.test.mjs

test-blender: build $(BLENDER)/.installed ## Check our files in Blender and MuJoCo, which take 500 MB of their own
	BLENDER_PYTHON=$(CURDIR)/$(BLENDER)/bin/python MUJOCO_PYTHON=$(CURDIR)/$(BLENDER)/bin/python \
	  $(BIN)/pytest python/tests/test_blender.py python/tests/test_robot_pieces.py \
	  python/tests/test_artists_day.py

$(BUNNY): tests/tools/node_modules/.package-lock.json web/site/bunny.mjs
	@mkdir -p $(@D)
	node web/site/bunny.mjs > $@ || { rm -f $@; exit 1; }

$(BLENDER)/.installed:
	$(PYTHON3_11) -m venv $(BLENDER)
	$(BLENDER)/bin/python -m pip install --quiet bpy==5.0.1 mujoco==4.0.0
	touch $@

clean: ## Remove what the other targets made
	rm -rf $(OUT) $(VENV) $(BLENDER) target tests/tools/node_modules web/node_modules web/dist web/engine web/npm/dist $(PLAYER)

# The environment may be there already, without pip or without our tools.
$(VENV)/.tools: $(LOCK)
	test -x $(BIN)/python || $(PYTHON) -m venv $(VENV)
	@$(BIN)/python -c 'import sys; sys.exit(sys.version_info < (3, 11) and \
	  "$(VENV) has an older Python than 3.11: remove it and set PYTHON to a newer one")'
	$(BIN)/python -m pip --version >/dev/null 2>&1 || $(BIN)/python -m ensurepip
	$(BIN)/python -m pip install --quiet --require-hashes --requirement $(LOCK)
	touch $@

lock: ## Lock the versions and hashes of Python packages anew
	$(PYTHON) -m venv $(OUT)/lock
	$(OUT)/lock/bin/python -m pip install --quiet uv==0.13.9
	head -n 2 $(LOCK) > $(OUT)/lock/head
	$(OUT)/lock/bin/uv pip compile --quiet --upgrade --universal --python-version 3.11 --generate-hashes \
	  --no-header --no-annotate $(addprefix --extra ,$(LOCKED)) --output-file $(OUT)/lock/lock pyproject.toml
	cat $(OUT)/lock/head $(OUT)/lock/lock > $(LOCK)

# The tests use the wheel that a user gets, not the source tree. Where its panics come from is told without the folders of the
# machine that built it.
$(VENV)/.installed: $(VENV)/.tools $(PLAYER) $(RUST_SOURCES) $(PYTHON_SOURCES)
	rm -rf target/wheels
	cargo fetch --locked --quiet --target "$$(rustc --print host-tuple)"
	RUSTFLAGS="$$RUSTFLAGS $$(printf -- '--remap-path-prefix=%s=crates.io ' "$${CARGO_HOME:-$$HOME/.cargo}"/registry/src/*)" \
	  $(BIN)/maturin build --release --locked --interpreter $(BIN)/python --out target/wheels
	$(BIN)/python -m pip install --quiet --no-deps --no-index --force-reinstall target/wheels/frangible-*.whl
	touch $@

# Rust's compiler makes the module; `bindgen` makes what JavaScript calls it through.
$(ENGINE)/engine_bg.wasm: $(RUST_SOURCES)
	@rustup target list --installed 2>/dev/null | grep -q wasm32-unknown-unknown || \
	  rustup target add wasm32-unknown-unknown || { echo \
	  "Rust cannot compile for WebAssembly here: run rustup target add wasm32-unknown-unknown"; exit 1; }
	CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_RUSTFLAGS=-Ctarget-feature=$(VECTORS) \
	  cargo build --locked --package frangible-wasm --target wasm32-unknown-unknown --profile wasm
	cargo run --locked --quiet --manifest-path crates/wasm/bindgen/Cargo.toml --target-dir target/bindgen -- \
	  target/wasm32-unknown-unknown/wasm/frangible_wasm.wasm $(ENGINE)

$(PLAYGROUND): web/node_modules/.package-lock.json $(ENGINE)/engine_bg.wasm $(PLAYER_SOURCES)
	cd web && npm run playground --silent

$(NPM): web/node_modules/.package-lock.json $(ENGINE)/engine_bg.wasm $(NPM_SOURCES) python/frangible/scene.schema.json
	cd web && npm run package --silent

$(PLAYER): web/node_modules/.package-lock.json $(PLAYER_SOURCES)
	cd web && npm run build --silent

web/node_modules/.package-lock.json: web/package.json web/package-lock.json
	cd web && npm ci --no-audit --no-fund
	touch $@

tests/tools/node_modules/.package-lock.json: tests/tools/package.json tests/tools/package-lock.json
	cd tests/tools && npm ci --no-audit --no-fund
	touch $@
