#include "window/glfw_window.h"

#include <GLFW/glfw3.h>

#include <fmt/format.h>
#include <utility>

#include <fumarole/errors.h>

namespace fumarole::window {

namespace {

std::string last_error()
{
    const char* text = nullptr;
    glfwGetError(&text);
    return text == nullptr ? "no reason given" : text;
}

Modifiers modifiers_of(int bits)
{
    return {.shift = (bits & GLFW_MOD_SHIFT) != 0,
            .control = (bits & GLFW_MOD_CONTROL) != 0,
            .alt = (bits & GLFW_MOD_ALT) != 0};
}

std::vector<Event>& events_of(GLFWwindow* window)
{
    return *static_cast<std::vector<Event>*>(glfwGetWindowUserPointer(window));
}

}  // namespace

glm::ivec2 unscaled(glm::ivec2 size, glm::ivec2 pixels, double content_scale)
{
    if (size.x <= 0 || size.y <= 0 || pixels.x <= 0)
        return size;
    const double scale = content_scale * size.x / pixels.x;
    constexpr double kRounding = 1e-6;
    return glm::ivec2(glm::ceil(glm::dvec2(size) / scale - kRounding));
}

GlfwWindow::GlfwWindow(glm::ivec2 size, bool debug_context)
{
    if (glfwInit() == GLFW_FALSE)
        throw Error(fmt::format("no window can be opened: {}; `fumarole render` makes pictures "
                                "without a display",
                                last_error()));
    glfwWindowHint(GLFW_CONTEXT_VERSION_MAJOR, 4);
    glfwWindowHint(GLFW_CONTEXT_VERSION_MINOR, 5);
    glfwWindowHint(GLFW_OPENGL_PROFILE, GLFW_OPENGL_CORE_PROFILE);
    glfwWindowHint(GLFW_OPENGL_DEBUG_CONTEXT, debug_context ? GLFW_TRUE : GLFW_FALSE);
    glfwWindowHint(GLFW_SCALE_TO_MONITOR, GLFW_TRUE);
    glfwWindowHint(GLFW_DEPTH_BITS, 0);
    glfwWindowHint(GLFW_STENCIL_BITS, 0);
    window_ = glfwCreateWindow(size.x, size.y, "Fumarole", nullptr, nullptr);
    if (window_ == nullptr) {
        const std::string why = last_error();
        glfwTerminate();
        throw Error(fmt::format("this display gives no OpenGL 4.5 core context: {}; a newer driver "
                                "may, LIBGL_ALWAYS_SOFTWARE=1 draws on the processor, and "
                                "`fumarole render` needs no display",
                                why));
    }
    glfwSetWindowUserPointer(window_, &events_);
    glfwSetKeyCallback(window_, [](GLFWwindow* w, int key, int, int action, int bits) {
        if (action != GLFW_REPEAT || key == GLFW_KEY_BACKSPACE || key == GLFW_KEY_LEFT ||
            key == GLFW_KEY_RIGHT)
            events_of(w).emplace_back(KeyEvent{key, action != GLFW_RELEASE, modifiers_of(bits)});
    });
    glfwSetCharCallback(window_, [](GLFWwindow* w, unsigned codepoint) {
        events_of(w).emplace_back(TextEvent{codepoint});
    });
    glfwSetCursorPosCallback(window_, [](GLFWwindow* w, double x, double y) {
        events_of(w).emplace_back(PointerMoved{{x, y}});
    });
    glfwSetMouseButtonCallback(window_, [](GLFWwindow* w, int button, int action, int bits) {
        if (button <= GLFW_MOUSE_BUTTON_MIDDLE)
            events_of(w).emplace_back(
                PointerButton{button, action == GLFW_PRESS, modifiers_of(bits)});
    });
    glfwSetScrollCallback(
        window_, [](GLFWwindow* w, double, double y) { events_of(w).emplace_back(Wheel{y}); });
    glfwSetDropCallback(window_, [](GLFWwindow* w, int count, const char** paths) {
        events_of(w).emplace_back(FilesDropped{{paths, paths + count}});
    });
    for (const int shape :
         {GLFW_ARROW_CURSOR, GLFW_IBEAM_CURSOR, GLFW_HRESIZE_CURSOR, GLFW_HAND_CURSOR})
        cursors_.push_back(glfwCreateStandardCursor(shape));
    glfwMakeContextCurrent(window_);
    glfwSwapInterval(1);
}

GlfwWindow::~GlfwWindow()
{
    glfwTerminate();  // destroys windows and cursors too
}

std::vector<Event> GlfwWindow::poll(double seconds)
{
    if (seconds > 0)
        glfwWaitEventsTimeout(seconds);
    else
        glfwPollEvents();
    return std::exchange(events_, {});
}

void GlfwWindow::wake()
{
    glfwPostEmptyEvent();
}

void GlfwWindow::swap()
{
    glfwSwapBuffers(window_);
}

bool GlfwWindow::closing() const
{
    return glfwWindowShouldClose(window_) != GLFW_FALSE;
}

void GlfwWindow::close()
{
    glfwSetWindowShouldClose(window_, GLFW_TRUE);
}

bool GlfwWindow::minimised() const
{
    const glm::ivec2 area = pixels();
    return area.x <= 0 || area.y <= 0 || glfwGetWindowAttrib(window_, GLFW_ICONIFIED) != GLFW_FALSE;
}

void GlfwWindow::minimise(bool on)
{
    if (on)
        glfwIconifyWindow(window_);
    else
        glfwRestoreWindow(window_);
}

void GlfwWindow::resize(glm::ivec2 size)
{
    glfwSetWindowSize(window_, size.x, size.y);
}

void GlfwWindow::set_title(const std::string& title)
{
    glfwSetWindowTitle(window_, title.c_str());
}

void GlfwWindow::set_clipboard(const std::string& text)
{
    glfwSetClipboardString(window_, text.c_str());
}

std::string GlfwWindow::clipboard() const
{
    const char* text = glfwGetClipboardString(window_);
    return text == nullptr ? "" : text;
}

void GlfwWindow::set_cursor(int shape)
{
    if (shape == cursor_)
        return;
    cursor_ = shape;
    glfwSetCursor(window_, cursors_[static_cast<std::size_t>(shape)]);
}

glm::ivec2 GlfwWindow::size() const
{
    glm::ivec2 size(0);
    glfwGetWindowSize(window_, &size.x, &size.y);
    return size;
}

glm::ivec2 GlfwWindow::pixels() const
{
    glm::ivec2 size(0);
    glfwGetFramebufferSize(window_, &size.x, &size.y);
    return size;
}

glm::ivec2 GlfwWindow::unscaled_size() const
{
    return unscaled(size(), pixels(), content_scale());
}

double GlfwWindow::content_scale() const
{
    float x = 1, y = 1;
    glfwGetWindowContentScale(window_, &x, &y);
    return x > 0 ? x : 1;
}

gl::GetProc GlfwWindow::get_proc()
{
    return glfwGetProcAddress;
}

}  // namespace fumarole::window
