#include "context/headless_context.h"

// glad first: the headers below want to declare GL by themselves.
#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/osmesa.h>

#include <array>
#include <fmt/format.h>
#include <vector>

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

class Egl final : public HeadlessContext {
public:
    Egl()
    {
        display_ = first_display();
        if (display_ == EGL_NO_DISPLAY)
            throw Error("EGL: no display without a window system; a driver with "
                        "EGL_MESA_platform_surfaceless or EGL_EXT_platform_device is needed, or "
                        "use --backend osmesa");
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
        if (context_ == EGL_NO_CONTEXT ||
            eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) != EGL_TRUE) {
            const EGLint error = eglGetError();
            release();
            throw Error(fmt::format("EGL: can't make an OpenGL 4.5 core context (error {:#06x}); "
                                    "update the driver, or use --backend osmesa",
                                    error));
        }
    }
    Egl(const Egl&) = delete;
    Egl& operator=(const Egl&) = delete;
    ~Egl() override { release(); }

    [[nodiscard]] GetProc get_proc() const override { return eglGetProcAddress; }
    [[nodiscard]] std::string_view name() const override { return "egl"; }

private:
    /// A device's display where one initialises (a GPU first), else Mesa's surfaceless platform.
    static EGLDisplay first_display()
    {
        const auto query_devices =
            reinterpret_cast<PFNEGLQUERYDEVICESEXTPROC>(eglGetProcAddress("eglQueryDevicesEXT"));
        const auto platform_display = reinterpret_cast<PFNEGLGETPLATFORMDISPLAYEXTPROC>(
            eglGetProcAddress("eglGetPlatformDisplayEXT"));
        if (platform_display == nullptr)
            return EGL_NO_DISPLAY;
        std::array<EGLDeviceEXT, 16> devices{};
        EGLint count = 0;
        if (query_devices != nullptr)
            query_devices(static_cast<EGLint>(devices.size()), devices.data(), &count);
        for (EGLint i = 0; i < count; ++i) {
            EGLDisplay display = platform_display(EGL_PLATFORM_DEVICE_EXT,
                                                  devices[static_cast<std::size_t>(i)], nullptr);
            if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr) == EGL_TRUE)
                return display;
        }
        EGLDisplay display =
            platform_display(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, nullptr);
        if (display != EGL_NO_DISPLAY && eglInitialize(display, nullptr, nullptr) == EGL_TRUE)
            return display;
        return EGL_NO_DISPLAY;
    }

    void release()
    {
        eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
        if (context_ != EGL_NO_CONTEXT)
            eglDestroyContext(display_, context_);
        eglTerminate(display_);
    }

    EGLDisplay display_ = EGL_NO_DISPLAY;
    EGLContext context_ = EGL_NO_CONTEXT;
};

}  // namespace

std::unique_ptr<HeadlessContext> HeadlessContext::make(Backend backend)
{
    if (backend == Backend::egl)
        return std::make_unique<Egl>();
    return std::make_unique<OsMesa>();
}

}  // namespace fumarole::gl
