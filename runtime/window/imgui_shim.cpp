/* Wraps Dear ImGui in C functions. */
#include "runtime/window/imgui_shim.h"

#include "runtime/window/imgui_look_shim.h"

#include <imgui.h>
#include <imgui_internal.h>

#include <backends/imgui_impl_opengl3.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>
#include <string>

struct stp_ui {
    double scale = 0.0;
    stp_ui_clipboard clipboard = {};
    ImGuiContext *context = nullptr;
    bool draws = false; /* the part that draws with OpenGL was made */
};

namespace
{

/* Share of a row before its value begins; share of a panel that widgets take before their
 * labels. */
constexpr float VALUE_COLUMN = 0.36f, WIDGET_SHARE = 0.62f;

/* Memory ran out within a frame, and its panels stay open. Global, like all of ImGui's state. */
bool exhausted;

/* Allocates for ImGui, which uses memory without checking for NULL. */
void *allocate(size_t size, void *)
{
    void *memory = std::malloc(size);
    if (memory == nullptr) {
        exhausted = true;
        throw std::bad_alloc();
    }
    return memory;
}

void give_back(void *memory, void *)
{
    std::free(memory);
}

template <typename Body> void guard(Body body) noexcept
{
    try {
        if (!exhausted)
            body();
    } catch (...) {
        exhausted = true;
    }
}

template <typename Body> bool ask(Body body) noexcept
{
    try {
        return !exhausted && body();
    } catch (...) {
        exhausted = true;
        return false;
    }
}

void set_keys(ImGuiIO &io)
{
    static const ImGuiKey keys[STP_UI_KEY_COUNT] = {
        ImGuiKey_Tab,       ImGuiKey_LeftArrow, ImGuiKey_RightArrow, ImGuiKey_UpArrow,
        ImGuiKey_DownArrow, ImGuiKey_Home,      ImGuiKey_End,        ImGuiKey_Delete,
        ImGuiKey_Backspace, ImGuiKey_Enter,     ImGuiKey_Escape,     ImGuiKey_A,
        ImGuiKey_C,         ImGuiKey_V,         ImGuiKey_X,          ImGuiKey_Y,
        ImGuiKey_Z};
    for (int i = 0; i < STP_UI_KEY_COUNT; i++)
        io.KeyMap[keys[i]] = i;
}

const char *get_clipboard(void *user)
{
    const auto *clipboard = static_cast<const stp_ui_clipboard *>(user);
    return clipboard->get != nullptr ? clipboard->get(clipboard->context) : "";
}

void set_clipboard(void *user, const char *text)
{
    const auto *clipboard = static_cast<const stp_ui_clipboard *>(user);
    if (clipboard->set != nullptr)
        clipboard->set(clipboard->context, text);
}

void rescale(stp_ui *ui, double scale)
{
    if (ui->scale == scale)
        return;
    ui->scale = scale;
    if (!stp_ui_look_set(scale))
        throw std::bad_alloc();
    if (ui->draws) {
        ImGui_ImplOpenGL3_DestroyFontsTexture();
        ImGui_ImplOpenGL3_CreateFontsTexture();
    }
}

bool start(stp_ui *ui, double scale, const stp_ui_clipboard *clipboard)
{
    ui->context = ImGui::CreateContext();
    ImGuiIO &io = ImGui::GetIO();
    io.IniFilename = nullptr;
    io.LogFilename = nullptr;
    io.ConfigInputTextCursorBlink = false; /* frames are drawn only when something changes */
    io.BackendPlatformName = "stipple";
    if (clipboard != nullptr)
        ui->clipboard = *clipboard;
    io.ClipboardUserData = &ui->clipboard;
    io.GetClipboardTextFn = get_clipboard;
    io.SetClipboardTextFn = set_clipboard;
    set_keys(io);
    rescale(ui, scale);
    ui->draws = ImGui_ImplOpenGL3_Init("#version 450 core");
    return ui->draws;
}

void stop(stp_ui *ui)
{
    if (ui->draws)
        ImGui_ImplOpenGL3_Shutdown();
    if (ui->context != nullptr)
        ImGui::DestroyContext(ui->context);
    delete ui;
}

ImVec2 at(double x, double y)
{
    return ImVec2(static_cast<float>(x), static_cast<float>(y));
}

/* Copies word i of "a|b|c"; false past the last word. */
bool word_of(const char *words, int i, char *out, size_t bytes)
{
    while (i-- > 0) {
        words = std::strchr(words, '|');
        if (words == nullptr)
            return false;
        words++;
    }
    std::snprintf(out, bytes, "%.*s", static_cast<int>(std::strcspn(words, "|")), words);
    return true;
}

void set_widget_width()
{
    ImGui::SetNextItemWidth(WIDGET_SHARE * ImGui::GetContentRegionAvail().x);
}

bool begin_window(const char *name, const stp_ui_rect *rect, bool *open, ImGuiWindowFlags flags)
{
    ImGui::SetNextWindowPos(at(rect->x, rect->y));
    ImGui::SetNextWindowSize(at(rect->width, rect->height));
    flags |= ImGuiWindowFlags_NoResize | ImGuiWindowFlags_NoMove | ImGuiWindowFlags_NoCollapse |
             ImGuiWindowFlags_NoSavedSettings | ImGuiWindowFlags_NoNav;
    return ImGui::Begin(name, open, flags);
}

/* Breaks lines between words, never within one that fits: ImGui itself also breaks after the '.' of
 * a number. */
std::string broken(const char *text, float room)
{
    std::string lines(text);
    size_t begin = 0, gap = std::string::npos;
    for (size_t i = 1; i <= lines.size(); i++) {
        if (lines[i - 1] == ' ' || (i < lines.size() && lines[i] != ' '))
            continue;
        const char *line = lines.data() + begin, *end = lines.data() + i;
        if (gap != std::string::npos && ImGui::CalcTextSize(line, end).x > room) {
            begin = lines.find_first_not_of(' ', gap);
            lines[begin - 1] = '\n';
        }
        gap = i;
    }
    return lines;
}

/* Call after a field: whether the typed text is to be taken. */
bool field_left()
{
    return ImGui::IsItemDeactivatedAfterEdit();
}

} // namespace

stp_status stp_ui_create(stp_ui **out, double scale, const stp_ui_clipboard *clipboard,
                         stp_error *err)
{
    stp_ui *ui = nullptr;
    exhausted = false;
    ImGui::SetAllocatorFunctions(allocate, give_back, nullptr);
    try {
        ui = new (std::nothrow) stp_ui;
        if (ui == nullptr)
            return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the panels");
        if (!start(ui, scale, clipboard)) {
            stp_ui_destroy(&ui);
            return stp_error_set(err, STP_GL,
                                 "the panels cannot be drawn: Dear ImGui finds no "
                                 "OpenGL library: install libGL");
        }
        *out = ui;
        return STP_OK;
    } catch (...) {
        stp_ui_destroy(&ui);
        return stp_error_set(err, STP_OUT_OF_MEMORY, "no memory for the panels");
    }
}

void stp_ui_destroy(stp_ui **ui)
{
    try {
        if (*ui != nullptr)
            stop(*ui);
    } catch (...) { /* the process's end frees the rest */
    }
    *ui = nullptr;
}

bool stp_ui_is_exhausted(void)
{
    return exhausted;
}

void stp_ui_set_scale(stp_ui *ui, double scale)
{
    guard([&] { rescale(ui, scale); });
}

double stp_ui_scale(const stp_ui *ui)
{
    return ui->scale;
}

void stp_ui_pointer(stp_ui *, double x, double y)
{
    guard([&] { ImGui::GetIO().MousePos = at(x, y); });
}

void stp_ui_button_down(stp_ui *, int button, bool down)
{
    guard([&] {
        if (button >= 0 && button < 3)
            ImGui::GetIO().MouseDown[button] = down;
    });
}

void stp_ui_wheel(stp_ui *, double notches)
{
    guard([&] { ImGui::GetIO().MouseWheel += static_cast<float>(notches); });
}

void stp_ui_key_down(stp_ui *, stp_ui_key key, bool down, bool shift, bool control)
{
    guard([&] {
        ImGuiIO &io = ImGui::GetIO();
        io.KeysDown[key] = down;
        io.KeyShift = shift;
        io.KeyCtrl = control;
    });
}

void stp_ui_character(stp_ui *, uint32_t character)
{
    guard([&] { ImGui::GetIO().AddInputCharacter(character); });
}

void stp_ui_release_all(stp_ui *)
{
    guard([&] {
        ImGuiIO &io = ImGui::GetIO();
        for (bool &down : io.KeysDown)
            down = false;
        for (bool &down : io.MouseDown)
            down = false;
        io.KeyShift = io.KeyCtrl = false;
    });
}

bool stp_ui_wants_pointer(stp_ui *)
{
    return ask([&] {
        ImGui::UpdateHoveredWindowAndCaptureFlags(); /* for the pointer's present place */
        return ImGui::GetIO().WantCaptureMouse;
    });
}

bool stp_ui_wants_keys(const stp_ui *)
{
    return ask([&] { return ImGui::GetIO().WantTextInput; });
}

void stp_ui_begin(stp_ui *, int width, int height, double seconds_since_last)
{
    guard([&] {
        ImGuiIO &io = ImGui::GetIO();
        io.DisplaySize = at(width, height);
        io.DeltaTime = static_cast<float>(seconds_since_last > 1e-4 ? seconds_since_last : 1e-4);
        ImGui_ImplOpenGL3_NewFrame();
        ImGui::NewFrame();
    });
}

void stp_ui_end(stp_ui *)
{
    guard([&] {
        ImGui::Render();
        ImGui_ImplOpenGL3_RenderDrawData(ImGui::GetDrawData());
    });
}

bool stp_ui_panel_begin(const char *name, const stp_ui_rect *rect)
{
    return ask([&] {
        ImGuiWindowFlags flags =
            ImGuiWindowFlags_NoTitleBar | ImGuiWindowFlags_NoBringToFrontOnFocus;
        return begin_window(name, rect, nullptr, flags);
    });
}

bool stp_ui_dialog_begin(const char *title, const stp_ui_rect *rect, bool *open)
{
    return ask([&] { return begin_window(title, rect, open, ImGuiWindowFlags_None); });
}

void stp_ui_panel_end(void)
{
    guard([] { ImGui::End(); });
}

bool stp_ui_section(const char *title, bool *open)
{
    return ask([&] {
        ImGui::SetNextItemOpen(*open);
        *open = ImGui::CollapsingHeader(title);
        return *open;
    });
}

void stp_ui_text(const char *text)
{
    guard([&] { ImGui::TextUnformatted(text); });
}

void stp_ui_note(const char *text)
{
    guard([&] {
        ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyle().Colors[ImGuiCol_TextDisabled]);
        ImGui::PushTextWrapPos(0.0f);
        ImGui::TextUnformatted(text);
        ImGui::PopTextWrapPos();
        ImGui::PopStyleColor();
    });
}

void stp_ui_row(const char *label, const char *value)
{
    guard([&] {
        ImGui::PushStyleColor(ImGuiCol_Text, ImGui::GetStyle().Colors[ImGuiCol_TextDisabled]);
        ImGui::TextUnformatted(label);
        ImGui::PopStyleColor();
        ImGui::SameLine(VALUE_COLUMN * ImGui::GetWindowContentRegionMax().x);
        ImGui::PushTextWrapPos(0.0f); /* for a word wider than the column */
        ImGui::TextUnformatted(broken(value, ImGui::GetContentRegionAvail().x).c_str());
        ImGui::PopTextWrapPos();
    });
}

void stp_ui_swatch(const uint8_t rgb[3])
{
    guard([&] {
        float side = ImGui::GetFrameHeight();
        ImVec2 p = ImGui::GetCursorScreenPos();
        ImGui::GetWindowDrawList()->AddRectFilled(ImVec2(p.x, p.y + 0.2f * side),
                                                  ImVec2(p.x + 0.6f * side, p.y + 0.8f * side),
                                                  IM_COL32(rgb[0], rgb[1], rgb[2], 255));
        ImGui::Dummy(ImVec2(0.6f * side, side));
    });
}

bool stp_ui_button(const char *label)
{
    return ask([&] { return ImGui::Button(label); });
}

bool stp_ui_check(const char *label, bool *value)
{
    return ask([&] { return ImGui::Checkbox(label, value); });
}

bool stp_ui_choice(const char *label, int *value, const char *words, uint32_t allowed)
{
    return ask([&] {
        char word[64] = "", shown[64] = "";
        bool changed = false;
        word_of(words, *value, shown, sizeof shown);
        set_widget_width();
        if (!ImGui::BeginCombo(label, shown))
            return false;
        for (int i = 0; i < 32 && word_of(words, i, word, sizeof word); i++)
            if ((allowed >> i & 1u) != 0 && ImGui::Selectable(word, i == *value) && i != *value) {
                *value = i;
                changed = true;
            }
        ImGui::EndCombo();
        return changed;
    });
}

bool stp_ui_radio(int *value, const char *words, uint32_t allowed)
{
    return ask([&] {
        char word[64] = "";
        bool changed = false, first = true;
        for (int i = 0; i < 32 && word_of(words, i, word, sizeof word); i++) {
            if ((allowed >> i & 1u) == 0)
                continue;
            if (!first)
                ImGui::SameLine();
            first = false;
            if (ImGui::RadioButton(word, i == *value) && i != *value) {
                *value = i;
                changed = true;
            }
        }
        return changed;
    });
}

bool stp_ui_slider(const char *label, double *value, double low, double high, const char *format,
                   bool logarithmic)
{
    return ask([&] {
        set_widget_width();
        return ImGui::SliderScalar(label, ImGuiDataType_Double, value, &low, &high, format,
                                   ImGuiSliderFlags_AlwaysClamp |
                                       (logarithmic ? ImGuiSliderFlags_Logarithmic : 0));
    });
}

bool stp_ui_number(const char *label, double *value, const char *format)
{
    return ask([&] {
        double typed = *value;
        set_widget_width();
        ImGui::InputScalar(label, ImGuiDataType_Double, &typed, nullptr, nullptr, format);
        bool taken = std::isfinite(typed) && typed != *value;
        if (taken)
            *value = typed;
        return taken;
    });
}

bool stp_ui_numbers(const char *label, double values[3], const char *format)
{
    return ask([&] {
        bool taken = false;
        ImGui::PushID(label);
        float width =
            (ImGui::GetContentRegionAvail().x - 2.0f * ImGui::GetStyle().ItemSpacing.x) / 3.0f;
        for (int i = 0; i < 3; i++) {
            double typed = values[i];
            ImGui::PushID(i);
            ImGui::SetNextItemWidth(width);
            ImGui::InputScalar("", ImGuiDataType_Double, &typed, nullptr, nullptr, format);
            ImGui::PopID();
            if (i < 2)
                ImGui::SameLine();
            if (std::isfinite(typed) && typed != values[i]) {
                values[i] = typed;
                taken = true;
            }
        }
        ImGui::PopID();
        return taken;
    });
}

bool stp_ui_field(const char *label, char *text, size_t bytes)
{
    return ask([&] {
        set_widget_width();
        ImGui::InputText(label, text, bytes);
        return field_left();
    });
}

void stp_ui_focus_next(void)
{
    guard([] { ImGui::SetKeyboardFocusHere(); });
}

bool stp_ui_line(const char *label, char *text, size_t bytes)
{
    return ask([&] {
        ImGui::SetNextItemWidth(-1.0f);
        return ImGui::InputText(label, text, bytes, ImGuiInputTextFlags_EnterReturnsTrue);
    });
}

bool stp_ui_item(const char *text, bool chosen)
{
    return ask([&] { /* a name may have ## in it */
                     ImGui::PushID(text);
                     const bool pressed = ImGui::Selectable("##item", chosen);
                     ImGui::PopID();
                     ImGui::SameLine(0.0f, 0.0f);
                     ImGui::TextUnformatted(text);
                     return pressed;
    });
}

void stp_ui_chart(const char *text, const float *values, int count, int first, float top)
{
    guard([&] {
        ImGui::PushID(text);
        ImGui::PlotLines("", values, count, first, nullptr, 0.0f, top,
                         ImVec2(ImGui::GetContentRegionAvail().x, 3.2f * ImGui::GetFontSize()));
        ImGui::PopID();
        ImVec2 p = ImGui::GetItemRectMin();
        ImGui::GetWindowDrawList()->AddText(ImVec2(p.x + 5.0f, p.y + 2.0f),
                                            ImGui::GetColorU32(ImGuiCol_Text), text);
    });
}

void stp_ui_same_line(void)
{
    guard([] { ImGui::SameLine(); });
}

void stp_ui_space(void)
{
    guard([] { ImGui::Spacing(); });
}

void stp_ui_hint(const char *text)
{
    guard([&] {
        if (ImGui::IsItemHovered(ImGuiHoveredFlags_AllowWhenDisabled))
            ImGui::SetTooltip("%s", text);
    });
}

void stp_ui_push_id(int id)
{
    guard([&] { ImGui::PushID(id); });
}

void stp_ui_pop_id(void)
{
    guard([] { ImGui::PopID(); });
}

void stp_ui_disable_begin(bool disabled)
{
    guard([&] { ImGui::BeginDisabled(disabled); });
}

void stp_ui_disable_end(void)
{
    guard([] { ImGui::EndDisabled(); });
}
