# The engine's two libraries: see CMakeLists.txt beside this file.

add_library(motes_pure STATIC
  actions/action.cpp
  actions/ageing.cpp
  actions/expression.cpp
  actions/tables.cpp
  actions/kernels.cpp
  balance/cells.cpp
  balance/cuts.cpp
  balance/diffusive.cpp
  balance/histogram.cpp
  balance/load.cpp
  balance/named.cpp
  balance/pairwise.cpp
  balance/policy.cpp
  balance/prefix_cuts.cpp
  balance/prefix_sums.cpp
  balance/proportional.cpp
  balance/sample.cpp
  balance/shares.cpp
  domains/divide.cpp
  domains/domains.cpp
  image/assets.cpp
  image/behind.cpp
  image/bench.cpp
  image/bench_scenery.cpp
  image/bloom.cpp
  image/bloom_plan.cpp
  image/bloom_tiles.cpp
  image/brush.cpp
  image/buffer.cpp
  image/camera.cpp
  image/canvas.cpp
  image/cast_scene.cpp
  image/depth_blocks.cpp
  image/footprint.cpp
  image/image_levels.cpp
  image/lanes.cpp
  image/layers.cpp
  image/layout.cpp
  image/mesh_tree.cpp
  image/ordered.cpp
  image/partial_tile.cpp
  image/picture_light.cpp
  image/pieces.cpp
  image/prepared_scene.cpp
  image/projector.cpp
  image/records.cpp
  image/scenery.cpp
  image/sha256.cpp
  image/slots.cpp
  image/solids.cpp
  image/sort_fixed.cpp
  image/sort_tiles.cpp
  image/sort_wide.cpp
  image/tile_caster.cpp
  image/tile_layers.cpp
  image/tile_painter.cpp
  image/tone.cpp
  meetings/act.cpp
  meetings/cells.cpp
  meetings/extent.cpp
  meetings/kernels.cpp
  meetings/overlap.cpp
  meetings/pairs.cpp
  meetings/pyramid.cpp
  meetings/tie.cpp
  meetings/ties.cpp
  meshes/distance_grid.cpp
  meshes/form.cpp
  meshes/nearest.cpp
  meshes/surface.cpp
  particles/digest.cpp
  particles/exact_sum.cpp
  particles/ids.cpp
  particles/memory.cpp
  particles/plane_memory.cpp
  particles/schema.cpp
  particles/store.cpp
  particles/streams.cpp
  recording/bench.cpp
  recording/bench_actions.cpp
  recording/bench_meshes.cpp
  recording/bench_scene.cpp
  recording/bins.cpp
  recording/births.cpp
  recording/order.cpp
  recording/program.cpp
  recording/record.cpp
  recording/scene.cpp
  recording/select.cpp
  recording/spawn.cpp
  recording/sums.cpp
  roles/cast.cpp
  roles/ring.cpp
  roles/tree.cpp
  shapes/shape.cpp
  simd/isa.cpp
  threads/pool.cpp
)
# These differ from build to build by their instruction sets, and would keep pieces from being shared.
set_source_files_properties(actions/kernels.cpp image/lanes.cpp meetings/kernels.cpp simd/isa.cpp
  PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON)
set_target_properties(motes_pure PROPERTIES UNITY_BUILD ${MOTES_UNITY} UNITY_BUILD_BATCH_SIZE 45)
target_compile_options(motes_pure PRIVATE ${MOTES_O1})
# Searches for neighbours and keeps what is known of touches, particle by particle.
set_source_files_properties(meetings/act.cpp meetings/cells.cpp PROPERTIES COMPILE_OPTIONS $<$<CONFIG:Release>:-O3>)
target_include_directories(motes_pure PUBLIC ${CMAKE_CURRENT_SOURCE_DIR} ${CMAKE_CURRENT_BINARY_DIR}/generated)
target_link_libraries(motes_pure PUBLIC motes_flags PRIVATE Threads::Threads)
# pyproject.toml is the one place that has the version.
file(STRINGS ${PROJECT_SOURCE_DIR}/pyproject.toml version REGEX "^version = ")
string(REGEX REPLACE "version = (\".*\")" "\\1" version "${version}")
set_source_files_properties(recording/scene.cpp PROPERTIES COMPILE_DEFINITIONS MOTES_VERSION=${version})

# Compiled once for each instruction set: in two pieces with MOTES_UNITY.
set(image_lanes
  image/bloom_lanes.cpp
  image/cast_lanes.cpp
  image/project_lanes.cpp
  image/project_wide_lanes.cpp
  image/splat_lanes.cpp
  image/wide_lanes.cpp
)
set(particle_lanes
  actions/kernels_lanes.cpp
  meetings/meetings_lanes.cpp
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
  comm/clock.cpp
  comm/communicator.cpp
  comm/last_words.cpp
  comm/shared_memory.cpp
  comm/simulated_connections.cpp
  comm/simulated_ranks.cpp
  comm/simulated_scheduler.cpp
  comm/wait.cpp
  comm/stop_signals.cpp
  comm/watchdog.cpp
  frame/account.cpp
  frame/act.cpp
  frame/alarms.cpp
  frame/agree.cpp
  frame/balance.cpp
  frame/bench_births.cpp
  frame/bench_pictures.cpp
  frame/birth_numbers.cpp
  frame/birth_history.cpp
  frame/conversation.cpp
  frame/copies.cpp
  frame/costs.cpp
  frame/course.cpp
  frame/create.cpp
  frame/donate.cpp
  frame/draw_speeds.cpp
  frame/drawn.cpp
  frame/engine.cpp
  frame/exchange.cpp
  frame/follow.cpp
  frame/frame.cpp
  frame/histories.cpp
  frame/kept_rows.cpp
  frame/in_picture.cpp
  frame/log.cpp
  frame/meet.cpp
  frame/moments.cpp
  frame/neighbours.cpp
  frame/population.cpp
  frame/notes.cpp
  frame/read.cpp
  frame/recover.cpp
  frame/relay.cpp
  frame/render.cpp
  frame/render_bloom.cpp
  frame/render_composite.cpp
  frame/render_load.cpp
  frame/render_order.cpp
  frame/render_output.cpp
  frame/render_plan.cpp
  frame/render_project.cpp
  frame/render_tiles.cpp
  frame/shared_pictures.cpp
  frame/replay.cpp
  frame/report.cpp
  frame/reports.cpp
  frame/run_list.cpp
  frame/script.cpp
  frame/share.cpp
  frame/snapshot.cpp
  frame/spans.cpp
  frame/spawn.cpp
  frame/standing.cpp
  frame/stopwatch.cpp
  frame/sums.cpp
  frame/system.cpp
  frame/table.cpp
  frame/word.cpp
  snapshots/crc32c.cpp
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
