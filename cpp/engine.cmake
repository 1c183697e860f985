# The engine's two libraries, described in CMakeLists.txt.

# The families of actions between particles: a new one is only registered in actions/list.inc.
file(GLOB families CONFIGURE_DEPENDS RELATIVE ${CMAKE_CURRENT_SOURCE_DIR} interactions/kinds/*.cpp)

add_library(motes_pure STATIC
  actions/action.cpp
  actions/ageing.cpp
  actions/kernels.cpp
  actions/tables.cpp
  balance/cells.cpp
  balance/cuts.cpp
  balance/histogram.cpp
  balance/load.cpp
  balance/named.cpp
  balance/options.cpp
  balance/policy.cpp
  balance/prefix_sums.cpp
  balance/sample.cpp
  balance/shares.cpp
  base/hash.cpp
  base/memory.cpp
  base/sha256.cpp
  bench/bench_actions.cpp
  bench/bench_image.cpp
  bench/bench_meshes.cpp
  bench/bench_program.cpp
  bench/bench_scene.cpp
  bench/bench_scenery.cpp
  domains/curve.cpp
  domains/divide.cpp
  domains/domains.cpp
  expressions/expression.cpp
  expressions/formula.cpp
  image/buffer.cpp
  image/camera.cpp
  image/footprint.cpp
  image/layout.cpp
  image/mesh_corners.cpp
  image/post/bloom.cpp
  image/post/bloom_plan.cpp
  image/post/bloom_tiles.cpp
  image/post/canvas.cpp
  image/light/particle_light.cpp
  image/light/shadow_grid.cpp
  image/light/sky.cpp
  image/light/texture.cpp
  image/post/lanes.cpp
  image/post/layers.cpp
  image/post/picture_light.cpp
  image/post/tile_layers.cpp
  image/project/project_ribbons.cpp
  image/project/projector.cpp
  image/project/records.cpp
  image/project/sort_fixed.cpp
  image/project/sort_tiles.cpp
  image/project/sort_wide.cpp
  image/raster/behind.cpp
  image/raster/brush.cpp
  image/raster/depth_blocks.cpp
  image/raster/image_levels.cpp
  image/raster/ordered.cpp
  image/raster/partial_tile.cpp
  image/raster/pieces.cpp
  image/raster/tile_painter.cpp
  image/raycast/cast_scene.cpp
  image/raycast/prepared_scene.cpp
  image/raycast/scenery.cpp
  image/raycast/solid_shadows.cpp
  image/raycast/tile_caster.cpp
  image/slots.cpp
  image/solids.cpp
  image/tone.cpp
  ${families}
  interactions/cell_list.cpp
  interactions/clumps.cpp
  interactions/extent.cpp
  interactions/kernels.cpp
  interactions/neighbour_list.cpp
  interactions/overlap.cpp
  interactions/pair_action.cpp
  interactions/pairs.cpp
  interactions/ties.cpp
  interactions/walls.cpp
  meshes/assets.cpp
  meshes/deformation.cpp
  meshes/distance_field.cpp
  meshes/form.cpp
  meshes/bvh.cpp
  meshes/nearest.cpp
  meshes/surface.cpp
  particles/digest.cpp
  particles/exact_sum.cpp
  particles/ids.cpp
  particles/plane_memory.cpp
  particles/schema.cpp
  particles/store.cpp
  particles/streams.cpp
  particles/touches.cpp
  particles/trace.cpp
  particles/wrap.cpp
  program/bins.cpp
  program/events.cpp
  program/order.cpp
  program/program.cpp
  program/select.cpp
  program/sums.cpp
  recording/births.cpp
  recording/record.cpp
  recording/scene.cpp
  recording/source_total.cpp
  recording/spawn.cpp
  roles/cast.cpp
  roles/ring.cpp
  roles/tree.cpp
  shapes/shape.cpp
  simd/isa.cpp
  threads/pool.cpp
)
# These depend on a build's instruction sets, so a unity file that contains them could not be shared between builds.
set_source_files_properties(actions/kernels.cpp image/post/lanes.cpp interactions/kernels.cpp simd/isa.cpp
  PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
set_target_properties(motes_pure PROPERTIES UNITY_BUILD ${MOTES_UNITY} UNITY_BUILD_BATCH_SIZE 45)
target_compile_options(motes_pure PRIVATE ${MOTES_O1})
# Hot loops outside the lanes: neighbour search, contact memory, records near a surface, and the limits that benchmarks
# compare with.
set_source_files_properties(
  bench/bench_scene.cpp image/raster/behind.cpp interactions/cell_list.cpp
  interactions/kinds/colliding.cpp interactions/kinds/scripted.cpp interactions/kinds/sweeping.cpp
  interactions/neighbour_list.cpp
  PROPERTIES COMPILE_OPTIONS $<$<CONFIG:Release>:-O3>)
target_include_directories(motes_pure PUBLIC ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_BINARY_DIR}/generated)
target_link_libraries(motes_pure PUBLIC motes_flags PRIVATE Threads::Threads)
# Only pyproject.toml has the version.
file(STRINGS ${PROJECT_SOURCE_DIR}/pyproject.toml version REGEX "^version = ")
string(REGEX REPLACE "version = (\".*\")" "\\1" version "${version}")
set_source_files_properties(recording/scene.cpp PROPERTIES COMPILE_DEFINITIONS MOTES_VERSION=${version})

# Compiled once per instruction set: in two pieces with MOTES_UNITY.
set(image_lanes
  image/light/light_lanes.cpp
  image/post/bloom_lanes.cpp
  image/raycast/cast_lanes.cpp
  image/project/project_lanes.cpp
  image/project/project_wide_lanes.cpp
  image/raster/splat_lanes.cpp
  image/raster/wide_lanes.cpp
)
set(particle_lanes
  actions/kernels_lanes.cpp
  interactions/laws/interactions_lanes.cpp
  shapes/rare_lanes.cpp
)
set_source_files_properties(${image_lanes} PROPERTIES UNITY_GROUP image)
set_source_files_properties(${particle_lanes} PROPERTIES UNITY_GROUP particles)
foreach(isa IN LISTS MOTES_BUILT_ISAS)
  add_library(motes_lanes_${isa} OBJECT ${image_lanes} ${particle_lanes})
  set_target_properties(motes_lanes_${isa} PROPERTIES UNITY_BUILD ${MOTES_UNITY} UNITY_BUILD_MODE GROUP)
  target_link_libraries(motes_lanes_${isa} PRIVATE motes_isa_${isa})
  target_sources(motes_pure PRIVATE $<TARGET_OBJECTS:motes_lanes_${isa}>)
endforeach()

add_library(motes_engine STATIC
  base/crc32c.cpp
  bench/bench_births.cpp
  bench/bench_pictures.cpp
  comm/alone.cpp
  comm/clock.cpp
  comm/communicator.cpp
  comm/last_words.cpp
  comm/ledger.cpp
  comm/shared_memory.cpp
  comm/simulated_connections.cpp
  comm/simulated_ranks.cpp
  comm/simulated_scheduler.cpp
  comm/stop_signals.cpp
  comm/wait.cpp
  comm/watchdog.cpp
  engine/act/act.cpp
  engine/act/interaction_schedule.cpp
  engine/act/exchange.cpp
  engine/act/follow.cpp
  engine/act/ghost_exchange.cpp
  engine/act/ghosts.cpp
  engine/act/images.cpp
  engine/act/interact.cpp
  engine/act/read.cpp
  engine/act/motion.cpp
  engine/act/run_list.cpp
  engine/agree.cpp
  engine/balance/balance.cpp
  engine/balance/donate.cpp
  engine/balance/neighbours.cpp
  engine/births/birth_numbers.cpp
  engine/births/create.cpp
  engine/births/share.cpp
  engine/births/spawn.cpp
  engine/engine.cpp
  engine/frame.cpp
  engine/log/account.cpp
  engine/log/alarms.cpp
  engine/log/log.cpp
  engine/parts/manager.cpp
  engine/parts/snapshot.cpp
  engine/recover.cpp
  engine/recovery/replicas.cpp
  engine/recovery/standing.cpp
  engine/render/draw_speeds.cpp
  engine/render/drawn.cpp
  engine/render/in_picture.cpp
  engine/render/render.cpp
  engine/render/render_bloom.cpp
  engine/render/render_composite.cpp
  engine/render/render_load.cpp
  engine/render/render_order.cpp
  engine/render/render_output.cpp
  engine/render/render_plan.cpp
  engine/render/render_project.cpp
  engine/render/render_shadows.cpp
  engine/render/render_tiles.cpp
  engine/render/shared_pictures.cpp
  engine/replay.cpp
  engine/session/session.cpp
  engine/session/costs.cpp
  engine/session/links.cpp
  engine/session/relay.cpp
  engine/session/report.cpp
  engine/session/reports.cpp
  engine/session/spans.cpp
  engine/session/stopwatch.cpp
  engine/session/all_reduce.cpp
  engine/state/birth_history.cpp
  engine/state/histories.cpp
  engine/state/population.cpp
  engine/state/script.cpp
  engine/state/system.cpp
  engine/state/walls.cpp
  engine/sums/sums.cpp
  jsonl/kept_rows.cpp
  jsonl/table.cpp
  snapshots/file.cpp
  snapshots/part.cpp
  snapshots/writer.cpp
  soak/disasters.cpp
  soak/files.cpp
  soak/player.cpp
  soak/story.cpp
)
target_link_libraries(motes_engine PUBLIC motes_pure PRIVATE Threads::Threads)
set_target_properties(motes_engine PROPERTIES UNITY_BUILD ${MOTES_UNITY} UNITY_BUILD_BATCH_SIZE 40)
target_compile_options(motes_engine PRIVATE ${MOTES_O1})
