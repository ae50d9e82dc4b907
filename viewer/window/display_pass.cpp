#include "window/display_pass.h"

#include <cmath>

#include "shared/bindings.h"

namespace fumarole::window {

namespace {

glm::vec2 tone_of(const Display& display)
{
    return {std::exp2(display.exposure_ev),
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
        defines.emplace_back("SPLIT", "");
    if (request.comparison == Comparison::difference)
        defines.emplace_back("DIFFERENCE", "");
    shared::DisplayParams params{};
    params.area = glm::vec4(request.lower_left, request.size);
    params.tone = glm::vec4(tone_of(request.a.display), tone_of(request.b.display));
    params.comparison =
        glm::vec4(request.wipe * request.size.x, request.scale, request.tenth_of_mean_square, 0);
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
