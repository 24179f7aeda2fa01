// The executor of the paper's Figure 4, written plainly and as fast as that design can be: what ours is
// compared with. Section 4.1 names the arrays.
//
// Places and transitions are small integers; all arrays lie in one allocation, each on cache lines of
// its own. A place is looked at only after it was marked. The first of its transitions whose inputs are
// all marked, and that has not fired in this evaluation, fires at once; so `transitions_to_fire` never
// holds more than one and is left out. `history` counts per transition, which is what "every enabled
// transition has already fired" asks for, and holds the number of the evaluation, so that nothing is
// cleared in between. Of several transitions of a place it begins behind the one that it took last.
// Outputs are not looked at, which is right for safe nets and saves it work.
//
// The paper's arrays of bits have a byte per entry here: a quarter faster, as changes of neighbouring
// entries do not wait for each other.

#include <stdint.h>
#include <stdlib.h>
#include <string.h>

#define LINE 64u

// Lists of numbers in one array: list i is `entries[pointer[i]]` up to `entries[pointer[i + 1]]`.
typedef struct {
    uint32_t *pointer;
    uint16_t *entries;
} map;

// A circular buffer of places, each in it at most once. `first` and `behind` count on and on.
typedef struct {
    uint16_t *places;
    uint8_t *is_already_in_buffer;
    uint32_t mask, first, behind;
} to_do;

typedef struct {
    map place_to_transitions, transition_input_place, transition_output_place;
    // By place: where among its transitions to look first.
    uint16_t *next_transition;
    uint8_t *sink_places, *marking;
    to_do places_to_process, places_to_skip;
    // By transition: the last evaluation in which it fired.
    uint32_t *history;
    uint32_t evaluation, places;
} figure_4;

static inline int get(const uint8_t *flags, uint32_t i) { return flags[i]; }
static inline void set(uint8_t *flags, uint32_t i) { flags[i] = 1; }
static inline void clear(uint8_t *flags, uint32_t i) { flags[i] = 0; }

static inline void push(to_do *list, uint16_t place) {
    if (!get(list->is_already_in_buffer, place)) {
        set(list->is_already_in_buffer, place);
        list->places[list->behind++ & list->mask] = place;
    }
}

static inline uint16_t pop(to_do *list) {
    uint16_t place = list->places[list->first++ & list->mask];
    clear(list->is_already_in_buffer, place);
    return place;
}

static inline void mark(figure_4 *net, uint16_t place) {
    set(net->marking, place);
    if (!get(net->sink_places, place)) push(&net->places_to_process, place);
}

static size_t room(size_t *used, size_t bytes) {
    size_t at = *used;
    *used += (bytes + LINE - 1) / LINE * LINE;
    return at;
}

// `starts[2 t]` is where in `arcs` the inputs of transition t begin, `starts[2 t + 1]` its outputs;
// `starts[2 transitions]` is the end. `is_sink` and `is_marked` have a byte per place. NULL without memory.
figure_4 *figure_4_new(uint32_t places, uint32_t transitions, const uint32_t *starts, const uint16_t *arcs,
                       const uint8_t *is_sink, const uint8_t *is_marked) {
    uint32_t all = starts[2 * transitions], inputs = 0;
    for (uint32_t t = 0; t < transitions; t++) inputs += starts[2 * t + 1] - starts[2 * t];
    uint32_t ring = 1;
    while (ring < places) ring *= 2;
    size_t used = 0;
    size_t self = room(&used, sizeof(figure_4));
    // What has to be zero at first comes first.
    size_t marking = room(&used, places), sinks = room(&used, places);
    size_t in_process = room(&used, places), in_skip = room(&used, places);
    size_t next = room(&used, places * 2u), history = room(&used, transitions * 4u);
    size_t users = room(&used, (places + 2u) * 4u);
    size_t zeros = used;
    size_t process = room(&used, ring * 2u), skip = room(&used, ring * 2u);
    size_t in_pointer = room(&used, (transitions + 1u) * 4u), in_entries = room(&used, inputs * 2u);
    size_t out_pointer = room(&used, (transitions + 1u) * 4u), out_entries = room(&used, (all - inputs) * 2u);
    size_t user_entries = room(&used, inputs * 2u);
    char *memory = aligned_alloc(LINE, used);
    if (!memory) return NULL;
    memset(memory, 0, zeros);
    figure_4 *net = (figure_4 *)(memory + self);
    net->marking = (uint8_t *)(memory + marking);
    net->sink_places = (uint8_t *)(memory + sinks);
    net->next_transition = (uint16_t *)(memory + next);
    net->history = (uint32_t *)(memory + history);
    net->places_to_process = (to_do){(uint16_t *)(memory + process), (uint8_t *)(memory + in_process), ring - 1, 0, 0};
    net->places_to_skip = (to_do){(uint16_t *)(memory + skip), (uint8_t *)(memory + in_skip), ring - 1, 0, 0};
    net->transition_input_place = (map){(uint32_t *)(memory + in_pointer), (uint16_t *)(memory + in_entries)};
    net->transition_output_place = (map){(uint32_t *)(memory + out_pointer), (uint16_t *)(memory + out_entries)};
    net->place_to_transitions = (map){(uint32_t *)(memory + users), (uint16_t *)(memory + user_entries)};
    net->places = places;
    // Counted one further on, so that filling the lists moves each pointer to where its list begins.
    uint32_t *user = net->place_to_transitions.pointer, i = 0, o = 0;
    for (uint32_t t = 0; t < transitions; t++) {
        net->transition_input_place.pointer[t] = i;
        net->transition_output_place.pointer[t] = o;
        uint32_t a = starts[2 * t];
        for (; a < starts[2 * t + 1]; a++) {
            net->transition_input_place.entries[i++] = arcs[a];
            user[arcs[a] + 2]++;
        }
        for (; a < starts[2 * t + 2]; a++) net->transition_output_place.entries[o++] = arcs[a];
    }
    net->transition_input_place.pointer[transitions] = i;
    net->transition_output_place.pointer[transitions] = o;
    for (uint32_t p = 2; p < places + 2; p++) user[p] += user[p - 1];
    for (uint32_t t = 0; t < transitions; t++)
        for (uint32_t a = starts[2 * t]; a < starts[2 * t + 1]; a++)
            net->place_to_transitions.entries[user[arcs[a] + 1]++] = (uint16_t)t;
    for (uint32_t p = 0; p < places; p++)
        if (is_sink[p]) set(net->sink_places, p);
    for (uint32_t p = 0; p < places; p++)
        if (is_marked[p]) mark(net, (uint16_t)p);
    return net;
}

void figure_4_free(figure_4 *net) { free(net); }

void figure_4_set_marking(figure_4 *net, const uint16_t *places, uint32_t count) {
    while (net->places_to_process.first != net->places_to_process.behind) pop(&net->places_to_process);
    while (net->places_to_skip.first != net->places_to_skip.behind) pop(&net->places_to_skip);
    memset(net->marking, 0, net->places);
    for (uint32_t i = 0; i < count; i++) mark(net, places[i]);
}

int figure_4_is_marked(const figure_4 *net, uint16_t place) { return get(net->marking, place); }

static inline int is_enabled(const figure_4 *net, uint16_t t) {
    const map *in = &net->transition_input_place;
    for (uint32_t a = in->pointer[t]; a < in->pointer[t + 1]; a++)
        if (!get(net->marking, in->entries[a])) return 0;
    return 1;
}

static inline void fire(figure_4 *net, uint16_t t) {
    const map *in = &net->transition_input_place, *out = &net->transition_output_place;
    net->history[t] = net->evaluation;
    for (uint32_t a = in->pointer[t]; a < in->pointer[t + 1]; a++) clear(net->marking, in->entries[a]);
    for (uint32_t a = out->pointer[t]; a < out->pointer[t + 1]; a++) mark(net, out->entries[a]);
}

// Fires each transition at most once, until none is enabled that has not fired, or until `firings` have.
static inline uint32_t evaluate(figure_4 *net, uint32_t firings, uint16_t *trace) {
    uint32_t fired = 0;
    net->evaluation++;
    while (net->places_to_skip.first != net->places_to_skip.behind)
        push(&net->places_to_process, pop(&net->places_to_skip));
    while (fired < firings && net->places_to_process.first != net->places_to_process.behind) {
        uint16_t place = pop(&net->places_to_process);
        if (!get(net->marking, place)) continue;
        const map *users = &net->place_to_transitions;
        uint32_t from = users->pointer[place], count = users->pointer[place + 1] - from;
        uint32_t at = net->next_transition[place];
        int fired_already = 0;
        for (uint32_t looked = 0; looked < count; looked++) {
            uint16_t t = users->entries[from + at];
            if (++at == count) at = 0;
            if (!is_enabled(net, t)) continue;
            if (net->history[t] == net->evaluation) {
                fired_already = 1;
                continue;
            }
            net->next_transition[place] = (uint16_t)at;
            fire(net, t);
            if (trace) trace[fired] = t;
            fired++;
            fired_already = 0;
            break;
        }
        if (fired_already) push(&net->places_to_skip, place);
    }
    return fired;
}

// One evaluation; `trace` has room for each transition once.
uint32_t figure_4_traced(figure_4 *net, uint32_t firings, uint16_t *trace) { return evaluate(net, firings, trace); }

// Many evaluations without any call in between; returns how many transitions fired.
uint64_t figure_4_evaluations(figure_4 *net, uint32_t count, uint32_t firings) {
    uint64_t fired = 0;
    while (count--) fired += evaluate(net, firings, NULL);
    return fired;
}
