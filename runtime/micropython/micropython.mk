# A module of USER_C_MODULES, for ports that are built by make.
RAYGRID_DIR := $(USERMOD_DIR)
SRC_USERMOD_C += $(RAYGRID_DIR)/modraygrid.c
SRC_USERMOD_LIB_C += $(RAYGRID_DIR)/raygrid.c
# The single file has inline functions that are no header's, and not all are used.
CFLAGS_USERMOD += -I$(RAYGRID_DIR) -Wno-unused-function
