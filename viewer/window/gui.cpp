#include "window/gui.h"

#include <algorithm>
#include <backends/imgui_impl_opengl3.h>
#include <imgui.h>
#include <utility>

#include <GLFW/glfw3.h>

namespace fumarole::window {

namespace {

constexpr float kFontPixels = 15;

void set_keys(ImGuiIO& io)
{
    const auto map = [&](ImGuiKey_ to, int key) { io.KeyMap[to] = key; };
    map(ImGuiKey_Tab, GLFW_KEY_TAB);
    map(ImGuiKey_LeftArrow, GLFW_KEY_LEFT);
    map(ImGuiKey_RightArrow, GLFW_KEY_RIGHT);
    map(ImGuiKey_UpArrow, GLFW_KEY_UP);
    map(ImGuiKey_DownArrow, GLFW_KEY_DOWN);
    map(ImGuiKey_Home, GLFW_KEY_HOME);
    map(ImGuiKey_End, GLFW_KEY_END);
    map(ImGuiKey_Delete, GLFW_KEY_DELETE);
    map(ImGuiKey_Backspace, GLFW_KEY_BACKSPACE);
    map(ImGuiKey_Space, GLFW_KEY_SPACE);
    map(ImGuiKey_Enter, GLFW_KEY_ENTER);
    map(ImGuiKey_Escape, GLFW_KEY_ESCAPE);
    map(ImGuiKey_KeyPadEnter, GLFW_KEY_KP_ENTER);
    map(ImGuiKey_A, GLFW_KEY_A);
    map(ImGuiKey_C, GLFW_KEY_C);
    map(ImGuiKey_V, GLFW_KEY_V);
    map(ImGuiKey_X, GLFW_KEY_X);
    map(ImGuiKey_Y, GLFW_KEY_Y);
    map(ImGuiKey_Z, GLFW_KEY_Z);
}

void set_style()
{
    ImGui::StyleColorsDark();
    ImGuiStyle& style = ImGui::GetStyle();
    style.WindowRounding = 0;
    style.FrameRounding = 2;
    style.WindowBorderSize = 0;
    style.ItemSpacing = {6, 4};
    style.Colors[ImGuiCol_WindowBg] = {0.10f, 0.10f, 0.11f, 0.96f};
}

}  // namespace

Gui::Gui(GlfwWindow& window) : window_{window}, context_{ImGui::CreateContext()}
{
    ImGuiIO& io = ImGui::GetIO();
    io.IniFilename = nullptr;  // what is kept is kept in our own file
    io.LogFilename = nullptr;
    io.BackendPlatformName = "fumarole";
    io.BackendFlags |= ImGuiBackendFlags_HasMouseCursors;
    set_keys(io);
    io.ClipboardUserData = this;
    io.SetClipboardTextFn = [](void* self, const char* text) {
        static_cast<Gui*>(self)->window_.set_clipboard(text);
    };
    io.GetClipboardTextFn = [](void* self) {
        Gui& gui = *static_cast<Gui*>(self);
        gui.clipboard_ = gui.window_.clipboard();
        return gui.clipboard_.c_str();
    };
    ImGui_ImplOpenGL3_Init("#version 450 core");
}

Gui::~Gui()
{
    ImGui_ImplOpenGL3_Shutdown();
    ImGui::DestroyContext(context_);
}

void Gui::feed(const Event& event)
{
    ImGuiIO& io = ImGui::GetIO();
    if (const auto* key = std::get_if<KeyEvent>(&event)) {
        if (key->key >= 0 && key->key < IM_ARRAYSIZE(io.KeysDown))
            io.KeysDown[key->key] = key->down;
        io.KeyCtrl = key->modifiers.control;
        io.KeyShift = key->modifiers.shift;
        io.KeyAlt = key->modifiers.alt;
    } else if (const auto* text = std::get_if<TextEvent>(&event)) {
        io.AddInputCharacter(text->codepoint);
    } else if (const auto* moved = std::get_if<PointerMoved>(&event)) {
        pointer_ = moved->to;
    } else if (const auto* button = std::get_if<PointerButton>(&event)) {
        down_[button->button] = button->down;
        pressed_[button->button] |= button->down;
        if (button->twice)
            io.MouseClickedTime[button->button] = ImGui::GetTime();
    } else if (const auto* wheel = std::get_if<Wheel>(&event)) {
        io.MouseWheel += static_cast<float>(wheel->notches);
    }
}

void Gui::scale_to(double content_scale)
{
    if (content_scale == scale_)
        return;
    scale_ = content_scale;
    ImGui::GetStyle() = {};
    set_style();
    ImGui::GetStyle().ScaleAllSizes(static_cast<float>(scale_));
}

void Gui::update_letters()
{
    if (!lettering_.update(*ImGui::GetIO().Fonts, kFontPixels * static_cast<float>(scale_)))
        return;
    // The first texture is made with the shaders, by NewFrame; the others by nobody else.
    if (std::exchange(has_texture_, true)) {
        ImGui_ImplOpenGL3_DestroyFontsTexture();
        ImGui_ImplOpenGL3_CreateFontsTexture();
    }
}

void Gui::begin(const std::vector<Event>& events, double seconds)
{
    ImGuiIO& io = ImGui::GetIO();
    scale_to(window_.content_scale());
    update_letters();
    const glm::vec2 size(window_.size()), pixels(window_.pixels());
    io.DisplaySize = {size.x, size.y};
    io.DisplayFramebufferScale = {pixels.x / std::max(size.x, 1.0f),
                                  pixels.y / std::max(size.y, 1.0f)};
    io.DeltaTime = static_cast<float>(std::clamp(seconds, 1e-4, 1.0));
    for (const Event& event : events)
        feed(event);
    io.MousePos = {static_cast<float>(pointer_.x), static_cast<float>(pointer_.y)};
    for (int i = 0; i < 3; ++i)
        io.MouseDown[i] = down_[i] || pressed_[i];
    std::fill_n(pressed_, 3, false);
    ImGui_ImplOpenGL3_NewFrame();
    ImGui::NewFrame();
}

void Gui::end()
{
    switch (ImGui::GetMouseCursor()) {
    case ImGuiMouseCursor_TextInput:
        window_.set_cursor(1);
        break;
    case ImGuiMouseCursor_ResizeEW:
        window_.set_cursor(2);
        break;
    case ImGuiMouseCursor_Hand:
        window_.set_cursor(3);
        break;
    default:
        window_.set_cursor(0);
    }
    ImGui::Render();
    lettering_.look_at(*ImGui::GetDrawData());
    ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
}

bool Gui::has_pointer() const
{
    return ImGui::GetIO().WantCaptureMouse;
}

bool Gui::has_keys() const
{
    return ImGui::GetIO().WantTextInput;
}

}  // namespace fumarole::window
