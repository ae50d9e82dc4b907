#include "pass/step_boxes.h"

#include <algorithm>
#include <cassert>

#include "shared/bindings.h"

namespace fumarole::pass {

namespace {

constexpr const char* kSeeBoxes = "pass/see_boxes.comp";
constexpr const char* kChooseSteps = "pass/choose_steps.comp";
constexpr const char* kWantDepths = "pass/want_depths.comp";

std::vector<shared::StepBox> step_boxes(const std::vector<medium::Occupied>& occupied)
{
    std::vector<shared::StepBox> boxes;
    for (const medium::Occupied& part : occupied)
        for (const medium::OccupiedBox& box : part.boxes) {
            const double most = box.most;
            boxes.push_back({glm::dvec4(box.bounds.min, longest_step(part.detail, most)),
                             glm::dvec4(box.bounds.max, most)});
        }
    return boxes;
}

}  // namespace

void StepBoxes::prepare() const
{
    for (const char* file : {kSeeBoxes, kChooseSteps, kWantDepths})
        tools_.programs.get({file}, {});
}

void StepBoxes::upload_boxes()
{
    if (boxes_id_ == tools_.media.occupied_id())
        return;
    const std::vector<shared::StepBox> boxes = step_boxes(tools_.media.occupied());
    const std::size_t bytes = std::max<std::size_t>(1, boxes.size()) * sizeof(shared::StepBox);
    // A medium that moves has as many from frame to frame, mostly.
    if (boxes_.bytes() != bytes)
        boxes_ = {tools_.device, "step boxes", bytes};
    else
        boxes_.invalidate();
    if (!boxes.empty())
        boxes_.write(boxes.data(), bytes);
    boxes_id_ = tools_.media.occupied_id();
}

void StepBoxes::write_block(const StepView& view, const gl::Texture& march,
                            const gl::Texture& picture)
{
    shared::StepViewParams params{};
    const std::vector<medium::Occupied>& occupied = tools_.media.occupied();
    assert(occupied.size() <= MAX_STEP_PARTS);
    int first = 0;
    for (std::size_t i = 0; i < occupied.size(); ++i) {
        const int count = static_cast<int>(occupied[i].boxes.size());
        params.view_from_boxes[i] = view.frame.host.view_from_world * occupied[i].world_from_box;
        params.parts[i] = {first, count, 0, 0};
        first += count;
    }
    params.clip_from_view = view.frame.host.clip_from_view;
    const int slots = view.slots.count();
    for (int i = 0; i <= slots; ++i)
        params.ends[i / 2][i % 2] = view.slots.begin(i);
    for (int i = 0; i < slots; ++i)
        params.lengths[i / 2][i % 2] = view.slots.length(i);
    assert(view.lights.size() <= MAX_LIGHT_POINTS);
    for (std::size_t i = 0; i < view.lights.size(); ++i)
        params.lights[i] = {view.lights[i].pixel, view.lights[i].metres, view.lights[i].least,
                            view.lights[i].view_z, 0};
    params.picture = view.frame.host.color.size;
    params.offset = view.offset;
    params.near = view.frame.eye.near;
    params.scale = view.scale;
    params.reach = view.reach;
    params.slack = StepView::kSlack;
    params.depth_rounding = StepView::kDepthRounding;
    params.shaft = view.shaft();
    params.far_share = view.far_share;
    params.tile_radius = view.tile_radius();
    params.march_tiles = march.size();
    params.picture_tiles = picture.size();
    params.slot_count = slots;
    params.slot_width = view.slots.width();
    params.light_count = static_cast<int>(view.lights.size());
    params.spaced = view.spaced ? 1 : 0;
    params.lit = view.lit ? 1 : 0;
    params.shafts_anywhere = view.shafts_anywhere ? 1 : 0;
    block_.write(params);
    tools_.device->BindBufferBase(GL_UNIFORM_BUFFER, STEP_VIEW_BLOCK, block_.id());
}

void StepBoxes::fill(const StepView& view, const gl::Texture& march, const gl::Texture& depth,
                     const gl::Texture& picture)
{
    const gl::Device& gl = tools_.device;
    upload_boxes();
    write_block(view, march, picture);
    const std::size_t bytes = sizeof(shared::SeenTile) * static_cast<std::size_t>(march.size().x) *
                              static_cast<std::size_t>(march.size().y);
    if (seen_.bytes() != bytes)
        seen_ = {gl, "seen tiles", bytes};
    // The last frame's.
    gl->MemoryBarrier(GL_BUFFER_UPDATE_BARRIER_BIT | GL_TEXTURE_UPDATE_BARRIER_BIT |
                      GL_SHADER_IMAGE_ACCESS_BARRIER_BIT);
    seen_.clear();
    for (const gl::Texture* tiles : {&depth, &picture})
        tiles->clear(GL_RGBA_INTEGER, GL_UNSIGNED_INT, nullptr);
    const auto groups = [](glm::ivec3 tiles) {
        return glm::uvec2((glm::ivec2(tiles) + (PICTURE_GROUP - 1)) / PICTURE_GROUP);
    };
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, STEP_BOXES_BUFFER, boxes_.id());
    gl->BindBufferBase(GL_SHADER_STORAGE_BUFFER, STEP_SEEN_BUFFER, seen_.id());

    std::size_t most = 0;
    for (const medium::Occupied& part : tools_.media.occupied())
        most = std::max(most, part.boxes.size());
    picture.bind_image(STEP_TILES_IMAGE, GL_WRITE_ONLY);
    gl->UseProgram(tools_.programs.get({kSeeBoxes}, {}).id());
    if (most > 0)
        gl->DispatchCompute(static_cast<GLuint>(most),
                            static_cast<GLuint>(tools_.media.occupied().size()), 1);
    gl->MemoryBarrier(GL_SHADER_STORAGE_BARRIER_BIT | GL_TEXTURE_FETCH_BARRIER_BIT);

    march.bind_image(STEP_TILES_IMAGE, GL_WRITE_ONLY);
    gl->UseProgram(tools_.programs.get({kChooseSteps}, {}).id());
    const glm::uvec2 over_march = groups(march.size());
    gl->DispatchCompute(over_march.x, over_march.y, 1);

    depth.bind_image(STEP_TILES_IMAGE, GL_WRITE_ONLY);
    picture.bind(STEP_TILES_UNIT);
    gl->UseProgram(tools_.programs.get({kWantDepths}, {}).id());
    const glm::uvec2 over_picture = groups(picture.size());
    gl->DispatchCompute(over_picture.x, over_picture.y, 1);
    gl->MemoryBarrier(GL_TEXTURE_FETCH_BARRIER_BIT);
}

}  // namespace fumarole::pass
