#include "base/enumerators.h"
#include "bindings/bindings.h"
#include "comm/alone.h"
#include "comm/environment.h"
#include "comm/mpi_transport.h"
#include "comm/stop_signals.h"
#include "engine/births/share.h"
#include "engine/recovering_engine.h"
#include "particles/trace.h"
#include "recording/scene.h"

namespace motes::bindings {
namespace {

using Engine = engine::RecoveringEngine;

// Holds a function of the script. The engine may destroy it on any thread and at any time without the GIL: when the
// engine's constructor throws, or with the last copy.
std::shared_ptr<py::function> held(py::function call) {
  return {new py::function(std::move(call)), [](py::function* dropped) {
            const py::gil_scoped_acquire gil;
            delete dropped;
          }};
}

comm::Life life_of(const py::object& said) {
  const auto [lives, text] = said.cast<std::pair<std::optional<bool>, std::string>>();
  using State = comm::Life::State;
  return {!lives ? State::unknown : *lives ? State::lives : State::gone, text};
}

// Returns the callbacks of the engine's waits: they handle interrupts, and tell whether the awaited process is still
// alive.
comm::Watch make_watch(py::function while_waiting, py::function describe, double warn_s, std::optional<double> limit_s,
                       std::optional<py::function> life, std::optional<py::function> warn) {
  comm::Watch watch;
  watch.while_waiting = [call = held(std::move(while_waiting))](int rank) {
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    (*call)(rank);
  };
  watch.describe = [call = held(std::move(describe))](int rank) {
    const py::gil_scoped_acquire gil;
    return (*call)(rank).cast<std::string>();
  };
  watch.warn_s = warn_s;
  watch.limit_s = limit_s.value_or(0);
  if (life) {
    watch.life = [call = held(std::move(*life))](int rank) {
      const py::gil_scoped_acquire gil;
      return life_of((*call)(rank));
    };
  }
  if (warn) {
    watch.warn = [call = held(std::move(*warn))](const std::string& text) {
      const py::gil_scoped_acquire gil;
      (*call)(text);
    };
  }
  return watch;
}

// Returns the settings of a run, as World passes them.
engine::Settings make_settings(const py::dict& facts) {
  engine::Settings settings;
  settings.seed = facts["seed"].cast<std::uint64_t>();
  settings.dt = facts["dt"].cast<double>();
  settings.substeps = facts["substeps"].cast<int>();
  settings.log.digest = facts["digest"].cast<bool>();
  settings.log.directory = facts["log"].cast<std::string>();
  settings.log.hosts = facts["hosts"].cast<std::vector<std::string>>();
  if (!facts["policy"].is_none()) settings.policy = facts["policy"].cast<std::shared_ptr<balance::Policy>>();
  settings.combine = base::enumerator<engine::Combine>("combine", facts["combine"].cast<std::string>());
  settings.births = engine::births_named(facts["births"].cast<std::string>());
  settings.fan_out = facts["fan_out"].cast<int>();
  settings.threads = facts["threads"].cast<int>();
  if (!facts["grain"].is_none()) settings.grain = facts["grain"].cast<std::size_t>();
  settings.skin = facts["skin"].cast<std::optional<float>>();
  settings.shares_pictures = facts["shares_pictures"].cast<bool>();
  settings.wall_clock = facts["clock"].cast<std::string>() == "wall";
  settings.speed = facts["speed"].cast<double>();
  settings.log.spans = facts["spans"].cast<bool>();
  settings.log.continued_from = facts["continued_from"].cast<std::uint64_t>();
  settings.stop_signal = &comm::stop_signal;
  return settings;
}

std::unique_ptr<Engine> make_engine(std::optional<int> comm, const std::tuple<int, int, std::vector<int>>& roles,
                                    const py::dict& facts, py::function while_waiting, py::function describe,
                                    double warn_s, std::optional<double> limit_s, std::optional<py::function> life,
                                    std::optional<py::function> warn) {
  auto [manager, image_generator, calculators] = roles;
  roles::Cast cast{manager, image_generator, std::move(calculators)};
  comm::Watch watch =
      make_watch(std::move(while_waiting), std::move(describe), warn_s, limit_s, std::move(life), std::move(warn));
  engine::Settings settings = make_settings(facts);
  const py::gil_scoped_release release;
  auto communicator =
      std::make_unique<comm::Communicator>(comm ? comm::make_mpi(*comm) : comm::make_alone(), std::move(watch));
  roles::check(cast, communicator->size());
  return std::make_unique<Engine>(std::move(communicator), std::move(cast), std::move(settings));
}

int add_system(Engine& engine, const std::string& name, std::optional<std::uint64_t> capacity, unsigned axes,
               const py::object& space, int domains_of, const image::Sprite& sprite,
               const std::vector<std::tuple<std::string, int, std::array<float, 3>>>& attributes,
               const std::vector<std::tuple<int, float, float>>& periods) {
  recording::SystemDefinition definition;
  definition.name = name;
  if (capacity) definition.capacity = *capacity;
  definition.axes.bits = static_cast<std::uint8_t>(axes);
  definition.domains_of = domains_of;
  definition.sprite = sprite;
  if (py::isinstance<py::str>(space)) {
    definition.space.kind = domains::Space::Kind::fit;
  } else if (!space.is_none()) {
    const auto [low, high] = space.cast<std::pair<double, double>>();
    definition.space = {domains::Space::Kind::finite, low, high};
  }
  for (const auto& [attribute, width, initial] : attributes)
    definition.attributes.push_back({attribute, width, {initial[0], initial[1], initial[2]}});
  for (const auto& [axis, low, high] : periods) {
    definition.periods.bits = static_cast<std::uint8_t>(definition.periods.bits | 1u << axis);
    definition.periods.along.at(static_cast<std::size_t>(axis)) = {low, high};
  }
  return engine.add_system(std::move(definition));
}

py::dict times(const engine::PhaseTimes& t) {
  py::dict d;
  d["t_create_s"] = t.create;
  d["t_act_s"] = t.act;
  d["t_report_s"] = t.report;
  d["t_exchange_s"] = t.exchange;
  d["t_balance_s"] = t.balance;
  d["t_render_s"] = t.render;
  d["t_project_s"] = t.project;
  d["t_draw_s"] = t.draw;
  d["t_assemble_s"] = t.assemble;
  d["t_wait_s"] = t.wait;
  d["t_frame_s"] = t.frame;
  return d;
}

py::object last_row(const Engine& engine) {
  if (!engine.last_row()) return py::none();
  const engine::FrameRow& row = *engine.last_row();
  py::dict d = times(row.times);
  d["frame"] = row.frame;
  d["particles"] = row.particles;
  d["exchanged"] = row.exchanged;
  d["exchanged_bytes"] = row.exchanged_bytes;
  d["dropped"] = row.dropped;
  d["imbalance"] = row.imbalance;
  d["slowest_rank"] = row.slowest_rank;
  return d;
}

// Return read-only views of the engine's memory, valid while the script's function runs.
template <class T>
py::array_t<T> view_of(const std::vector<T>& values, py::ssize_t width) {
  const auto rows = static_cast<py::ssize_t>(values.size()) / width;
  const std::vector<py::ssize_t> shape = width == 1 ? std::vector{rows} : std::vector{rows, width};
  py::array_t<T> view(shape, values.data(), py::none());
  view.attr("flags").attr("writeable") = false;
  return view;
}

py::object views_of(const interactions::PairList* pairs) {
  if (pairs == nullptr) return py::none();
  return py::make_tuple(view_of(pairs->id, 1), view_of(pairs->other_id, 1), view_of(pairs->position, 3),
                        view_of(pairs->other_position, 3), view_of(pairs->velocity, 3),
                        view_of(pairs->other_velocity, 3));
}

void on_callback(Engine& engine, py::function call) {
  engine.on_callback([script = held(std::move(call))](const engine::Call& now) {
    const py::gil_scoped_acquire gil;
    py::object chosen = py::none();
    if (now.chosen != nullptr) {
      chosen = py::array_t<std::uint32_t>(static_cast<py::ssize_t>(now.chosen->size()), now.chosen->data());
    }
    const py::object said = (*script)(now.system, now.callback, now.begin, chosen, views_of(now.pairs));
    if (now.changes == nullptr || said.is_none()) return;
    const auto changes = said.cast<FloatArray>();  // the package has checked its shape
    now.changes->assign(changes.data(), changes.data() + changes.size());
  });
}

void on_orders(Engine& engine, py::function call) {
  engine.on_orders([script = held(std::move(call))] {
    const py::gil_scoped_acquire gil;
    return (*script)().cast<std::string>();
  });
}

void secure(Engine& engine, std::optional<py::function> first) {
  std::function<void()> films;
  if (first) {
    films = [script = held(std::move(*first))] {
      const py::gil_scoped_acquire gil;
      (*script)();
    };
  }
  released([&] { engine.secure(films); });
}

std::vector<py::bytes> tell(Engine& engine, py::function say) {
  const auto said = [script = held(std::move(say))] {
    const py::gil_scoped_acquire gil;
    return (*script)().cast<std::string>();
  };
  const std::vector<std::string> texts = released([&] { return engine.tell(said); });
  return {texts.begin(), texts.end()};
}

py::object gather(Engine& engine, int system, bool to_all) {
  const auto store = released([&] { return engine.gather(system, to_all); });
  if (!store) return py::none();
  py::dict columns;
  for (int a = 0; a < store->schema().size(); ++a) columns[store->schema()[a].name.c_str()] = column_copy(*store, a);
  columns["id"] = id_copy(*store, 0, store->size());
  return columns;
}

// Returns one number per bin, the last dimension fastest, or one per weight.
py::array sum(Engine& engine, int system, const std::string& verb, const program::Sum& what) {
  const auto asked = base::enumerator<recording::Verb>("verb", verb);
  program::Totals totals = released([&] { return engine.sum(system, asked, what); });
  return std::visit(
      [](auto& values) -> py::array {
        const auto n = static_cast<py::ssize_t>(values.size());
        return owned_array(std::move(values), {n});
      },
      totals);
}

// Gives this rank other particles: see fill().
int replace(Engine& engine, int system, std::size_t count, const std::vector<std::pair<int, py::array>>& columns,
            bool numbered) {
  std::vector<Rows> rows;
  for (const auto& [attribute, values] : columns) rows.push_back({attribute, values});
  return fill(engine.emptied(system), count, rows, numbered, engine.pool());
}

// Returns the vertices, (n, 3), and the triangles, (m, 3), of a surface.
std::pair<py::array, py::array> surface(Engine& engine, int system, double cell, double radius) {
  surfaces::Skin skin = released([&] { return engine.surface(system, {cell, radius}); });
  const auto rows = [](auto& numbers) -> py::array {
    const auto n = static_cast<py::ssize_t>(numbers.size()) / 3;
    return owned_array(std::move(numbers), {n, 3});
  };
  return {rows(skin.vertices), rows(skin.triangles)};
}

// Calls the script's function for its numbers and bytes; returns the totals and, on the manager, all ranks' bytes.
std::pair<std::vector<std::int64_t>, std::vector<py::bytes>> prepare_write(Engine& engine, const std::string& what,
                                                                           bool reads, const py::function& prepare) {
  const engine::Notes notes = released([&] {
    return engine.prepare_write(what, reads, [&] {
      const py::gil_scoped_acquire gil;
      auto [numbers, text] = prepare().cast<std::pair<std::vector<std::int64_t>, std::string>>();
      return engine::Note{std::move(numbers), std::move(text)};
    });
  });
  return {notes.totals, {notes.texts.begin(), notes.texts.end()}};
}

// Returns a system with computed values: a recording that skipped computing catches up first.
engine::System& computed(Engine& engine, int system) {
  engine.catch_up();
  return engine.system(system);
}

using Facts = std::vector<std::pair<std::string, std::string>>;

py::bytes scene_bytes(const Engine& engine, const Facts& facts) {
  recording::Scene scene;
  scene.facts = facts;
  for (const base::Bytes& list : engine.kept_lists()) scene.frames.push_back(list.view());
  base::Bytes bytes;
  recording::write(scene, bytes);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::string combined(const std::vector<particles::Digest>& systems) { return particles::combine(systems).text(); }

// Binds reads of this rank's particles, and of what all ranks know of a system.
void bind_reading(py::class_<Engine>& engine) {
  engine
      .def(
          "local_column",
          [](Engine& e, int system, int attribute, std::size_t begin) {
            const engine::ParticlesView seen = e.seen(system);
            return column_view(*seen.store, attribute, begin, seen.count);
          },
          py::arg("system"), py::arg("attribute"), py::arg("begin") = 0)
      .def(
          "local_ids",
          [](Engine& e, int system, std::size_t begin) {
            const engine::ParticlesView seen = e.seen(system);
            return id_copy(*seen.store, begin, seen.count);
          },
          py::arg("system"), py::arg("begin") = 0)
      .def(
          "copy_columns",
          [](Engine& e, int system, const std::vector<int>& attributes) {
            const engine::ParticlesView seen = e.seen(system);
            return column_copies(*seen.store, attributes, seen.count, e.pool());
          },
          py::arg("system"), py::arg("attributes"))
      .def("used_attributes",
           [](Engine& e, int system) {
             const engine::ParticlesView seen = e.seen(system);
             return used_attributes(*seen.store, seen.count);
           })
      .def("initial_values",
           [](Engine& e, int system) {
             std::vector<particles::Value> values;
             for (const auto& a : e.system(system).schema.attributes()) values.push_back(a.initial);
             return values;
           })
      .def("local_size", [](Engine& e, int system) { return e.seen(system).count; })
      .def("memory_bytes", [](Engine& e, int system) { return e.seen(system).store->memory_bytes(); })
      .def("count", [](Engine& e, int system) { return computed(e, system).counts.alive; })
      .def("born", [](Engine& e, int system) { return computed(e, system).counts.born; })
      .def("dropped", [](Engine& e, int system) { return computed(e, system).counts.dropped; })
      .def("cuts", [](Engine& e, int system) {
        std::vector<std::pair<int, float>> cuts;
        for (const domains::Cut& cut : computed(e, system).domains.tree()) cuts.emplace_back(cut.axis, cut.at);
        return cuts;
      });
}

// Binds the picture of the last frame, on the image generator.
void bind_pictures(py::class_<Engine>& engine) {
  engine
      .def("take_pixels",
           [](Engine& e, int width, int height) {
             image::Pixels pixels = e.painter().take_pixels();
             if (pixels.size() != std::size_t{3} * static_cast<std::size_t>(height) * static_cast<std::size_t>(width)) {
               throw std::logic_error("the last picture has a different size, or was already taken");
             }
             return owned_array(std::move(pixels), {py::ssize_t{height}, py::ssize_t{width}, py::ssize_t{3}});
           })
      .def("set_image_sha256", &Engine::set_image_sha256)
      .def_property_readonly("render_path", [](Engine& e) { return std::string(base::name_of(e.painter().plan.path)); })
      .def("linear",
           [](Engine& e) {
             std::vector<float> light = e.painter().linear();
             const auto n = static_cast<py::ssize_t>(light.size());
             return owned_array(std::move(light), {n});
           })
      .def(
          "layer",
          [](Engine& e, std::uint8_t bit) {
            std::vector<float> values = e.painter().layer(bit);
            const auto n = static_cast<py::ssize_t>(values.size());
            return owned_array(std::move(values), {n});
          },
          py::arg("bit"));
}

// Binds what needs no engine: columns of every system, roles, the MPI library.
void bind_facts(py::module_& m) {
  m.def("builtin_attributes", [] {
    std::vector<std::pair<std::string, int>> names;
    const particles::Schema schema;
    for (const particles::Attribute& a : schema.attributes()) names.emplace_back(a.name, a.width);
    return names;
  });
  m.def("trace_attributes", &particles::trace_attributes, py::arg("periodic"));
  m.def("cast", [](const std::string& kind, int size) {
    const roles::Cast cast = kind == "shared" ? roles::cast_shared(size) : roles::cast_auto(size);
    return std::make_tuple(cast.manager, cast.image_generator, cast.calculators);
  });
  m.def("check_roles", [](const std::tuple<int, int, std::vector<int>>& roles, int size) {
    roles::check({std::get<0>(roles), std::get<1>(roles), std::get<2>(roles)}, size);
  });
  m.def("cast_left", [](const std::tuple<int, int, std::vector<int>>& roles, const std::vector<int>& survivors) {
    const roles::Cast cast = roles::cast_left({std::get<0>(roles), std::get<1>(roles), std::get<2>(roles)}, survivors);
    return std::make_tuple(cast.manager, cast.image_generator, cast.calculators);
  });
  m.def("describe_role", [](const std::tuple<int, int, std::vector<int>>& roles, int rank) {
    return roles::Cast{std::get<0>(roles), std::get<1>(roles), std::get<2>(roles)}.describe(rank);
  });
  m.def("take_rows", &take_rows, py::arg("rows"), py::arg("order"), py::arg("into"));
  m.def(
      "use_mpi", &comm::use_mpi, py::arg("module"), py::arg("world"),
      "Use the MPI library that a loaded module is linked to; return the name of its ABI. `world`: the module's number "
      "of COMM_WORLD, once MPI has started.");
  m.def("mpi_version", &comm::library_version);
  m.def("forget_mpi", &comm::forget_mpi,
        "Keep a process that was forked by a rank from calling MPI_Finalize; False if that is not possible.");
  m.def("mpi_can_survive", &comm::mpi_can_survive,
        "Whether the library is one in which the other ranks can continue when one is lost.");
}

}  // namespace

void bind_engine(py::module_& m) {
  py::class_<Engine> engine(m, "Engine");
  engine
      .def(py::init(&make_engine), py::arg("comm"), py::arg("roles"), py::arg("facts"), py::arg("while_waiting"),
           py::arg("describe"), py::arg("warn_s"), py::arg("limit_s"), py::arg("life") = py::none(),
           py::arg("warn") = py::none())
      .def("add_system", &add_system, py::arg("name"), py::arg("capacity"), py::arg("axes"), py::arg("space"),
           py::arg("domains_of"), py::arg("sprite"), py::arg("attributes"), py::arg("periods"))
      .def(
          "record_action", [](Engine& e, int system, const actions::Action& action) { e.record(system, action); },
          py::arg("system"), py::arg("action"))
      .def(
          "record_interaction",
          [](Engine& e, int first, int second, const actions::Action& action,
             const std::optional<actions::Action>& counterpart) {
            e.record_interaction(first, second, action, counterpart ? &*counterpart : nullptr);
          },
          py::arg("first"), py::arg("second"), py::arg("action"), py::arg("counterpart") = py::none())
      .def("wall_force", &Engine::wall_force, py::arg("wall"), Release())
      .def("next_birth", &Engine::next_birth, py::arg("system"), Release())
      .def("record_birth", [](Engine& e, int system, recording::Birth birth) { e.record(system, std::move(birth)); })
      .def("set_policy", [](Engine& e, std::shared_ptr<balance::Policy> policy) { e.set_policy(std::move(policy)); })
      .def("set_speed", &Engine::set_speed, py::arg("speed"))
      .def("set_sprite", &Engine::set_sprite, py::arg("system"), py::arg("sprite"))
      .def("set_clumps",
           [](Engine& e, int system, actions::TableKey spheres) { e.system(system).outside.clumps = spheres; })
      .def("start", &Engine::start, Release())
      .def("finish", &Engine::finish, Release())
      .def("secure", &secure, py::arg("first") = py::none())
      .def("tell", &tell, py::arg("say"))
      .def(
          "pass_camera", [](Engine& e, const image::View& view) { e.pass_camera(view.camera); }, py::arg("view"))
      .def("run_frame", &Engine::run_frame, py::arg("view"), py::arg("argument") = "", Release())
      .def("redraw", &Engine::redraw, py::arg("view"), py::arg("argument") = "", Release())
      .def("on_orders", &on_orders)
      .def("hear_orders", &Engine::hear_orders, py::arg("argument") = "", Release())
      .def_property_readonly("orders", &Engine::orders)
      .def(
          "digest", [](Engine& e) { return combined(e.digest()); }, Release())
      .def("gather", &gather, py::arg("system"), py::arg("to_all"))
      .def("prepare_write", &prepare_write, py::arg("what"), py::arg("reads"), py::arg("prepare"))
      .def("sum", &sum, py::arg("system"), py::arg("verb"), py::arg("sum"))
      .def("surface", &surface, py::arg("system"), py::arg("cell"), py::arg("radius"))
      .def(
          "run_pending", [](Engine& e, int system) { return e.local(system).preview; }, Release())
      .def("keep_preview", &Engine::keep_preview, Release())
      .def("keeps_copies", [](Engine& e, int system) { return e.system(system).keeps_copies; })
      .def("touched", &Engine::touched)
      .def("replace", &replace, py::arg("system"), py::arg("count"), py::arg("columns"), py::arg("numbered"))
      .def("release_views", [](Engine& e, int system) { e.seen(system).store->part_from_holders(); })
      .def(
          "record_callback",
          [](Engine& e, int system, const recording::Callback& callback) { e.record(system, callback); },
          py::arg("system"), py::arg("callback"))
      .def("record_spawn", [](Engine& e, int system, const recording::Spawn& spawn) { e.record(system, spawn); })
      .def("on_callback", &on_callback)
      .def("keep_lists", &Engine::keep_lists, py::arg("compute"))
      .def_property_readonly("recorded_frames", [](const Engine& e) { return e.kept_lists().size(); })
      .def("scene_bytes", &scene_bytes, py::arg("facts"))
      .def_property_readonly("frame", &Engine::frame)
      .def_property_readonly(
          "failed_at",
          [](const Engine& e) { return std::pair(e.session().failed_at().system, e.session().failed_at().item); })
      .def("set_saving", &Engine::set_saving, py::arg("saves"))
      .def_property_readonly("gave_up", [](const Engine& e) { return e.session().over(); })
      .def_property_readonly("stop_asked", &Engine::stop_asked)
      .def_property_readonly("times", [](const Engine& e) { return times(e.times()); })
      .def("take_remarks", &Engine::take_remarks)
      .def_property_readonly("last_row", &last_row);
  bind_reading(engine);
  bind_saving(engine);
  bind_losses(engine);
  bind_pictures(engine);
  bind_facts(m);
}

}  // namespace motes::bindings
