#include "context/headless_context.h"

// glad first: the headers below want to declare GL by themselves.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>

#include <array>
#include <fmt/format.h>
#include <optional>
#include <vector>

#include "context/device_look.h"
#include <fumarole/errors.h>

namespace fumarole::gl {

namespace {

class OsMesa final : public HeadlessContext {
public:
    OsMesa()
    {
        constexpr std::array kAttributes{OSMESA_FORMAT,
                                         OSMESA_RGBA,
                                         OSMESA_DEPTH_BITS,
                                         0,
                                         OSMESA_PROFILE,
                                         OSMESA_CORE_PROFILE,
                                         OSMESA_CONTEXT_MAJOR_VERSION,
                                         4,
                                         OSMESA_CONTEXT_MINOR_VERSION,
                                         5,
                                         0};
        context_ = OSMesaCreateContextAttribs(kAttributes.data(), nullptr);
        if (context_ == nullptr)
            throw Error("OSMesa: can't make an OpenGL 4.5 core context; Mesa 17 to 25.0 is "
                        "needed (Debian: libosmesa6), or use --backend egl");
        if (OSMesaMakeCurrent(context_, pixels_.data(), GL_UNSIGNED_BYTE, 1, 1) != GL_TRUE) {
            OSMesaDestroyContext(context_);
            throw Error("OSMesa: can't make the context current");
        }
    }
    OsMesa(const OsMesa&) = delete;
    OsMesa& operator=(const OsMesa&) = delete;
    ~OsMesa() override { OSMesaDestroyContext(context_); }

    [[nodiscard]] GetProc get_proc() const override { return OSMesaGetProcAddress; }
    [[nodiscard]] std::string_view name() const override { return "osmesa"; }

private:
    OSMesaContext context_ = nullptr;
    std::array<unsigned char, 4> pixels_{};  // OSMesa wants a picture; we draw to textures
};

/// What EGL lists, in its order.
struct EglDevice {
    EGLDeviceEXT handle = nullptr;  ///< none: Mesa's surfaceless platform, where EGL lists nothing
    bool software = false;          ///< EGL calls it a rasteriser
    std::string file;               ///< /dev/dri/card0, as far as it is known
};

bool has_word(const char* words, std::string_view word)
{
    const std::string_view all = words != nullptr ? words : "";
    for (std::size_t at = 0; (at = all.find(word, at)) != std::string_view::npos; ++at)
        if ((at == 0 || all[at - 1] == ' ') &&
            (at + word.size() == all.size() || all[at + word.size()] == ' '))
            return true;
    return false;
}

std::vector<EglDevice> list_devices()
{
    std::vector<EglDevice> found;
    const char* client = eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS);
    const auto query_devices =
        reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
    const auto query_string = reinterpret_cast<PFNEGLQUERYDEVICESTRINGEXTPROC>(
        eglGetProcAddress("eglQueryDeviceStringEXT"));
    std::array<EGLDeviceEXT, 64> handles{};
    EGLint count = 0;
    if (has_word(client, "EGL_EXT_platform_device") && query_devices != nullptr &&
        query_string != nullptr)
        query_devices(static_cast<EGLint>(handles.size()), handles.data(), &count);
    for (std::size_t i = 0; i < static_cast<std::size_t>(count); ++i) {
        EglDevice device{handles[i], false, ""};
        const char* extensions = query_string(device.handle, EGL_EXTENSIONS);
        device.software = has_word(extensions, "EGL_MESA_device_software");
        if (has_word(extensions, "EGL_EXT_device_drm"))
            if (const char* file = query_string(device.handle, EGL_DRM_DEVICE_FILE_EXT))
                device.file = file;
        found.push_back(device);
    }
    if (found.empty() && has_word(client, "EGL_MESA_platform_surfaceless"))
        found.push_back({});
    return found;
}

class Egl final : public HeadlessContext {
public:
    explicit Egl(const EglDevice& device)
    {
        const auto platform_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
            eglGetProcAddress("eglGetPlatformDisplayEXT"));
        if (platform_display == nullptr)
            throw Error("EGL can't open a display without a window system");
        display_ =
            device.handle != nullptr
                ? platform_display(EGL_PLATFORM_DEVICE_EXT, device.handle, nullptr)
                : platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        if (display_ == EGL_NO_DISPLAY || eglInitialize(display_, nullptr, nullptr) != EGL_TRUE)
            throw Error(fmt::format("EGL can't initialise it (error {:#06x}); is this user allowed "
                                    "to use the device's file?",
                                    eglGetError()));
        eglBindAPI(EGL_OPENGL_API);
        constexpr std::array<EGLint, 9> kAttributes{EGL_CONTEXT_MAJOR_VERSION,
                                                    4,
                                                    EGL_CONTEXT_MINOR_VERSION,
                                                    5,
                                                    EGL_CONTEXT_OPENGL_PROFILE_MASK,
                                                    EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                                                    EGL_CONTEXT_OPENGL_DEBUG,
                                                    EGL_FALSE,
                                                    EGL_NONE};
        context_ =
            eglCreateContext(display_, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, kAttributes.data());
        if (context_ == EGL_NO_CONTEXT || !make_current()) {
            const EGLint error = eglGetError();
            release();
            throw Error(
                fmt::format("EGL can't make an OpenGL 4.5 core context (error {:#06x})", error));
        }
    }
    Egl(const Egl&) = delete;
    Egl& operator=(const Egl&) = delete;
    ~Egl() override { release(); }

    [[nodiscard]] GetProc get_proc() const override { return eglGetProcAddress; }
    [[nodiscard]] std::string_view name() const override { return "egl"; }

    [[nodiscard]] bool make_current() const
    {
        return eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
    }
    void leave() const { eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT); }

private:
    void release()
    {
        leave();
        if (context_ != EGL_NO_CONTEXT)
            eglDestroyContext(display_, context_);
        eglTerminate(display_);
    }

    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
};

/// EGL's devices, and the contexts that were made to look at them.
class EglDevices {
public:
    EglDevices() : devices_{list_devices()}, contexts_(devices_.size()) {}

    [[nodiscard]] std::vector<bool> software() const
    {
        std::vector<bool> software;
        for (const EglDevice& device : devices_)
            software.push_back(device.software);
        return software;
    }

    DeviceDescription look(std::size_t i)
    {
        const EglDevice& device = devices_[i];
        DeviceDescription description;
        try {
            contexts_[i] = std::make_unique<Egl>(device);
            description = look_at_context(eglGetProcAddress);
            contexts_[i]->leave();
        } catch (const Error& error) {
            description.refusal = error.what();
        }
        description.software |= device.software;
        if (description.name.empty())
            description.name = device.software        ? "a rasteriser"
                               : !device.file.empty() ? device.file
                                                      : "of no known name";
        return description;
    }

    /// The context of a device that was looked at, made current.
    std::unique_ptr<HeadlessContext> take(std::size_t i)
    {
        if (!contexts_[i]->make_current())
            throw Error(
                fmt::format("EGL: the context of device {} can't be made current again", i));
        return std::move(contexts_[i]);
    }

private:
    std::vector<EglDevice> devices_;
    std::vector<std::unique_ptr<Egl>> contexts_;
};

}  // namespace

std::unique_ptr<HeadlessContext> HeadlessContext::make(const DeviceRequest& request)
{
    std::unique_ptr<HeadlessContext> context;
    DeviceChoice choice;
    if (request.backend == Backend::osmesa) {
        choice = choose_device(request, {}, {});
    } else {
        EglDevices devices;
        choice = choose_device(request, devices.software(),
                               [&](std::size_t i) { return devices.look(i); });
        if (choice.egl_device)
            context = devices.take(*choice.egl_device);
    }
    if (context == nullptr)
        context = std::make_unique<OsMesa>();
    context->choice_ = std::move(choice);
    return context;
}

std::vector<DeviceDescription> HeadlessContext::egl_devices()
{
    EglDevices devices;
    std::vector<DeviceDescription> all;
    for (std::size_t i = 0; i < devices.software().size(); ++i)
        all.push_back(devices.look(i));
    return all;
}

DeviceDescription HeadlessContext::osmesa_device()
{
    try {
        const OsMesa context;
        return look_at_context(OSMesaGetProcAddress);
    } catch (const Error& error) {
        return {.name = "OSMesa",
                .vendor = "",
                .version = "",
                .software = true,
                .refusal = error.what()};
    }
}

}  // namespace fumarole::gl
