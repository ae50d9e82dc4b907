#include "window/screen.h"

#include "study/srgb.h"
#include <fumarole/errors.h>
#include <fumarole/write/image_writer.h>

namespace fumarole::window {

namespace {

void GLAD_API_PTR keep_error(GLenum, GLenum type, GLuint, GLenum, GLsizei length,
                             const GLchar* text, const void* errors)
{
    if (type == GL_DEBUG_TYPE_ERROR || type == GL_DEBUG_TYPE_UNDEFINED_BEHAVIOR)
        static_cast<std::vector<std::string>*>(const_cast<void*>(errors))
            ->emplace_back(text, static_cast<std::size_t>(length));
}

}  // namespace

Screen::Screen(glm::ivec2 size, bool debug)
    : window_{size, debug}, device_{GlfwWindow::get_proc()}, display_{device_}
{
    if (!debug)
        return;
    device_->Enable(GL_DEBUG_OUTPUT);
    device_->Enable(GL_DEBUG_OUTPUT_SYNCHRONOUS);
    device_->DebugMessageCallback(keep_error, &errors_);
}

void Screen::clear(glm::ivec2 pixels)
{
    device_->BindFramebuffer(GL_DRAW_FRAMEBUFFER, 0);
    device_->Disable(GL_SCISSOR_TEST);
    device_->Viewport(0, 0, pixels.x, pixels.y);
    device_->ClearColor(0.07f, 0.07f, 0.08f, 1);
    device_->Clear(GL_COLOR_BUFFER_BIT);
}

void Screen::show(const DisplayRequest& request)
{
    if (request.a.picture != nullptr)
        display_.draw(request);
}

void Screen::take_screenshot(const std::string& file) const
{
    const glm::ivec2 size = window_.pixels();
    std::vector<std::uint8_t> bytes(static_cast<std::size_t>(size.x) *
                                    static_cast<std::size_t>(size.y) * 3);
    device_->BindFramebuffer(GL_READ_FRAMEBUFFER, 0);
    device_->ReadBuffer(GL_BACK);
    device_->PixelStorei(GL_PACK_ALIGNMENT, 1);
    device_->ReadPixels(0, 0, size.x, size.y, GL_RGB, GL_UNSIGNED_BYTE, bytes.data());
    Image image;
    image.width = size.x;
    image.height = size.y;
    image.channels = {"R", "G", "B"};
    for (int y = size.y - 1; y >= 0; --y)
        for (int x = 0; x < size.x * 3; ++x)
            image.pixels.push_back(study::srgb_decode(
                static_cast<float>(
                    bytes[static_cast<std::size_t>(y) * static_cast<std::size_t>(size.x) * 3 +
                          static_cast<std::size_t>(x)]) /
                255));
    write::write_png(image, {.exposure_ev = 0, .transform = Display::Transform::srgb}, file);
}

void Screen::check() const
{
    if (!errors_.empty())
        throw Error("OpenGL: " + errors_.front());
}

}  // namespace fumarole::window
