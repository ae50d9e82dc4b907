#include "window/display_pass.h"

#include <algorithm>
#include <cmath>

#include "shared/bindings.h"

namespace fumarole::window {

namespace {

shared::ToneParams tone_of(const Display& display)
{
    return {static_cast<float>(std::exp2(display.exposure_ev)),
            display.transform == Display::Transform::filmic ? 1.0f : 0.0f};
}

}  // namespace

DisplayPass::DisplayPass(const gl::Device& device)
    : device_{device}, programs_{device}, fullscreen_{device, "display"}, block_{device, "display"}
{
}

void DisplayPass::draw(const DisplayRequest& request)
{
    gl::Defines defines;
    if (request.comparison == Comparison::split)
        defines.emplace_back("kSplit", "");
    if (request.comparison == Comparison::difference)
        defines.emplace_back("kDifference", "");
    shared::DisplayParams params{};
    params.lower_left = glm::vec2(request.lower_left);
    params.size = glm::vec2(request.size);
    params.tone_a = tone_of(request.a.display);
    params.tone_b = tone_of(request.b.display);
    params.wipe = static_cast<float>(request.wipe) * static_cast<float>(request.size.x);
    params.largest_difference = static_cast<float>(request.scale);
    // Of two black pictures too: the inverse square root of 0 is undefined.
    params.tenth_mean_square = std::max(static_cast<float>(request.tenth_of_mean_square), 1e-30f);
    block_.write(params);
    const gl::Device& gl = device_;
    gl->BindBufferBase(GL_UNIFORM_BUFFER, FRAME_BLOCK, block_.id());
    request.a.picture->bind(DISPLAY_A_UNIT);
    if (request.b.picture != nullptr)
        request.b.picture->bind(DISPLAY_B_UNIT);
    gl->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    gl->Disable(GL_BLEND);
    gl->Disable(GL_SCISSOR_TEST);
    gl->Disable(GL_DEPTH_TEST);
    gl->Viewport(request.lower_left.x, request.lower_left.y, request.size.x, request.size.y);
    gl->UseProgram(programs_.get({"pass/fullscreen.vert", "pass/display.frag"}, defines).id());
    gl->BindVertexArray(fullscreen_.id());
    gl->DrawArrays(GL_TRIANGLES, 0, 3);
}

}  // namespace fumarole::window
